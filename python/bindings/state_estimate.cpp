// State estimation from the car's sensors.
#include "firstlap/estimation/state_estimate.hpp"

#include <stdexcept>
#include <vector>

#include "arrays.hpp"
#include "car_sections.hpp"
#include "modules.hpp"
#include "records.hpp"
#include "tables.hpp"
#include "views.hpp"

namespace firstlap {

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, StateEstimateParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("state_estimate", params);
}

inline void validate(const StateEstimateParams& params) { validate(params, "state_estimate"); }

}  // namespace firstlap

namespace firstlap::bindings {
namespace {

// Returns the rows of the table of MotionEstimate, one for each reading.
Numpy<double, 2> estimate_all(const sim::Car& car, const Rows& readings, const Rows& commands, const Values& dts) {
  constexpr std::size_t width = column_count<SensorReading>, command_width = column_count<DriveCommand>;
  const std::size_t n = dts.shape(0);
  if (readings.shape(0) != n || readings.shape(1) != width || commands.shape(0) != n ||
      commands.shape(1) != command_width) {
    throw std::invalid_argument("for dts (N,), readings must be (N, 5), commands (N, 2)");
  }
  StateEstimate estimate(car.state_estimate, sim::model_of(car));
  std::vector<double> rows;
  for (std::size_t i = 0; i < n; ++i) {
    estimate.update(from_row<SensorReading>(readings.data() + width * i),
                    from_row<DriveCommand>(commands.data() + command_width * i), dts.data()[i]);
    append_row(estimate.estimate(), rows);
  }
  return to_numpy(std::move(rows), column_count<MotionEstimate>);
}

}  // namespace

void bind_state_estimate(nb::module_& m) {
  bind_sections<StateEstimateParams>(m, "StateEstimateParams", "All parameters of the state estimation.");
  bind_record<MotionEstimate>(m, "MotionEstimate", "The estimated motion of the car.");
  nb::class_<StateEstimate>(m, "StateEstimate",
                            "Extended Kalman filter of wheel speed, gyro, accelerometer, steering angle and command.")
      .def(
          "__init__",
          [](StateEstimate* self, const StateEstimateParams& params, const sim::Car& car) {
            new (self) StateEstimate(params, sim::model_of(car));
          },
          nb::arg("params"), nb::arg("car"), "Raises ValueError with field, value and range.")
      .def(
          "update",
          [](StateEstimate& estimate, const SensorReading& reading, double speed, double steering_angle, double dt) {
            estimate.update(reading, {speed, steering_angle}, dt);
          },
          nb::arg("reading"), nb::arg("speed"), nb::arg("steering_angle"), nb::arg("dt"),
          "Updates with a reading `dt` [s] after the last one. `speed` [m/s], `steering_angle` [rad]: the command in "
          "effect from now on, NaN if it is not known.")
      .def(
          "set_params",
          [](StateEstimate& estimate, const StateEstimateParams& params, const sim::Car& car) {
            estimate.set_params(params, sim::model_of(car));
          },
          nb::arg("params"), nb::arg("car"), "Keeps the estimate. Raises ValueError like the constructor.")
      .def("estimate", &StateEstimate::estimate, "The current estimate.")
      .def("reset", &StateEstimate::reset, "Forgets everything.");
  m.def("estimate_all", &estimate_all, nb::arg("car"), nb::arg("readings"), nb::arg("commands"), nb::arg("dts"),
        "(N, K) rows of the table of MotionEstimate. readings (N, 5), commands (N, 2): rows of the tables of "
        "SensorReading and DriveCommand, the command in effect before each reading; dts (N,) [s] before each.");
}

}  // namespace firstlap::bindings
