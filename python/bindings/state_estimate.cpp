// State estimation for cars with poor odometry.
#include "firstlap/estimation/state_estimate.hpp"

#include "modules.hpp"
#include "tables.hpp"

namespace firstlap {

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, StateEstimateParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("state_estimate", params);
}

inline void validate(const StateEstimateParams& params) { validate(params, "state_estimate"); }

}  // namespace firstlap

namespace firstlap::bindings {

void bind_state_estimate(nb::module_& m) {
  bind_sections<StateEstimateParams>(m, "StateEstimateParams", "All parameters of the state estimation.");
  nb::class_<StateEstimate>(m, "StateEstimate", "Extended Kalman filter of wheel speed, gyro and steering angle.")
      .def(
          "__init__", [](StateEstimate* self, const StateEstimateParams& params) { new (self) StateEstimate(params); },
          nb::arg("params"), "Raises ValueError with field, value and range.")
      .def(
          "predict",
          [](StateEstimate& estimate, double steering_angle, double dt) {
            estimate.predict({0.0, steering_angle}, dt);
          },
          nb::arg("steering_angle"), nb::arg("dt"), "Predicts by dt [s] with a commanded steering angle [rad].")
      .def("measure_speed", &StateEstimate::measure_speed, nb::arg("speed"), "[m/s] wheel speed.")
      .def("measure_yaw_rate", &StateEstimate::measure_yaw_rate, nb::arg("yaw_rate"), "[rad/s] gyro.")
      .def("measure_steering", &StateEstimate::measure_steering, nb::arg("steering_angle"), "[rad]")
      .def("state", &StateEstimate::state, "The current estimate.")
      .def_prop_ro("yaw_rate_bias", &StateEstimate::yaw_rate_bias, "[rad/s] bias of the gyro.")
      .def("reset", &StateEstimate::reset, "Forgets everything.");
}

}  // namespace firstlap::bindings
