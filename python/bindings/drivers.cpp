// The opponents: parameters, drivers and what they saw and thought; and drivers written in Python.
#include <cstdint>
#include <nanobind/ndarray.h>
#include <string>

#include "arrays.hpp"
#include "callback_driver.hpp"
#include "firstlap/drivers/center_pid.hpp"
#include "firstlap/drivers/disparity_extender.hpp"
#include "firstlap/drivers/follow_the_gap.hpp"
#include "modules.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

using drivers::CenterPid;
using drivers::DisparityExtender;
using drivers::FollowTheGap;

template <class T>
Numpy<T, 1> copy(const Buffer<T>& buffer) {
  return to_numpy(std::vector<T>(buffer.begin(), buffer.end()));
}

nb::tuple as_tuple(const StepResult& result) {
  return nb::make_tuple(result.command.speed, result.command.steering_angle, to_string(result.status));
}

nb::dict as_dict(const FollowTheGap::Trace& trace) {
  nb::dict entry;
  entry["ranges"] = copy(trace.ranges);
  entry["first_beam"] = trace.first_beam;
  entry["beam_step"] = trace.beam_step;
  entry["free"] = copy(trace.free);
  entry["step"] = trace.step;
  entry["threshold"] = trace.threshold;
  entry["run"] = nb::make_tuple(trace.run_first * trace.step, trace.run_last * trace.step);
  entry["window"] = trace.window;
  entry["aim"] = trace.aim;
  entry["aim_free"] = trace.aim_free;
  entry["nearest"] = nb::make_tuple(trace.nearest.x, trace.nearest.y);
  entry["wanted"] = trace.wanted;
  entry["arc"] = trace.arc;
  entry["arc_free"] = trace.arc_free;
  entry["result"] = as_tuple(trace.result);
  return entry;
}

nb::dict as_dict(const DisparityExtender::Trace& trace) {
  nb::dict entry;
  entry["ranges"] = copy(trace.ranges);
  entry["extended"] = copy(trace.extended);
  entry["disparities"] = copy(trace.disparities);
  entry["first_beam"] = trace.first_beam;
  entry["beam_step"] = trace.beam_step;
  entry["block"] = nb::make_tuple(trace.block_first, trace.block_last);
  entry["aim"] = trace.aim;
  entry["aim_free"] = trace.aim_free;
  entry["straight_free"] = trace.straight_free;
  entry["wanted"] = trace.wanted;
  entry["held_left"] = trace.held_left;
  entry["held_right"] = trace.held_right;
  entry["result"] = as_tuple(trace.result);
  return entry;
}

nb::dict as_dict(const drivers::WallEstimate& wall) {
  nb::dict entry;
  entry["side"] = wall.side;
  entry["ahead"] = wall.ahead;
  entry["angle"] = wall.angle;
  entry["distance"] = wall.distance;
  entry["preview"] = wall.preview;
  return entry;
}

nb::dict as_dict(const CenterPid::Trace& trace) {
  nb::dict entry;
  entry["ranges"] = copy(trace.ranges);
  entry["first_beam"] = trace.first_beam;
  entry["beam_step"] = trace.beam_step;
  entry["left"] = as_dict(trace.left);
  entry["right"] = as_dict(trace.right);
  entry["error"] = trace.error;
  entry["derivative"] = trace.derivative;
  entry["preview"] = trace.preview;
  entry["p_term"] = trace.p_term;
  entry["i_term"] = trace.i_term;
  entry["d_term"] = trace.d_term;
  entry["free"] = trace.free;
  entry["result"] = as_tuple(trace.result);
  return entry;
}

// A driver with its parameters and its trace.
template <class AnyDriver, class Params>
void bind_driver(nb::module_& m, const std::string& name, const char* doc) {
  bind_sections<Params>(m, (name + "Params").c_str(), "Every parameter of the driver, in sections.");
  nb::class_<AnyDriver, Driver>(m, name.c_str(), doc)
      .def(nb::init<const Params&>(), nb::arg("params"), "Raises ValueError with field, value and range.")
      .def(
          "trace", [](const AnyDriver& driver) { return as_dict(driver.trace()); },
          "What the last step saw and thought; angles in the laser's frame.");
}

}  // namespace

void bind_drivers(nb::module_& m) {
  bind_driver<FollowTheGap, drivers::FollowTheGapParams>(m, "FollowTheGap", "Steers into the best gap.");
  bind_driver<DisparityExtender, drivers::DisparityExtenderParams>(m, "DisparityExtender",
                                                                   "Steers to where the most way is free.");
  bind_driver<CenterPid, drivers::CenterPidParams>(m, "CenterPid", "Steers to the middle between the walls.");
  nb::class_<CallbackDriver, Driver>(m, "CallbackDriver", "A driver that is written in Python.")
      .def(nb::init<nb::object>(), nb::arg("driver"),
           "`driver` has reset() and step(scan: LaserScan, state: VehicleState, dt) -> (speed, steering_angle, "
           "status). What it raises ends the race.")
      .def("raise_error", &CallbackDriver::raise_error,
           "Raises what the Python object raised, once; until its reset the car is told to stop.");
}

}  // namespace firstlap::bindings
