// The reactive drivers: parameters, drivers and traces; and drivers written in Python.
#include <string>

#include "callback_driver.hpp"
#include "firstlap/drivers/center_pid.hpp"
#include "firstlap/drivers/disparity_extender.hpp"
#include "firstlap/drivers/follow_the_gap.hpp"
#include "modules.hpp"
#include "tables.hpp"
#include "to_python.hpp"

namespace firstlap::bindings {
namespace {

using drivers::CenterPid;
using drivers::DisparityExtender;
using drivers::FollowTheGap;

// Binds a driver with its parameters and its trace.
template <class AnyDriver, class Params>
void bind_driver(nb::module_& m, const std::string& name, const char* doc) {
  bind_sections<Params>(m, (name + "Params").c_str(), "All parameters of the driver, in sections.");
  nb::class_<AnyDriver, Driver>(m, name.c_str(), doc)
      .def(nb::init<const Params&>(), nb::arg("params"), "Raises ValueError with field, value and range.")
      .def(
          "trace", [](const AnyDriver& driver) { return as_dict(driver.trace()); },
          "Intermediate results of the last step; angles in the LiDAR's frame. See docs/results-format.md.");
}

}  // namespace

void bind_drivers(nb::module_& m) {
  bind_driver<FollowTheGap, drivers::FollowTheGapParams>(m, "FollowTheGap",
                                                         "Follow the gap: steers into the best gap.");
  bind_driver<DisparityExtender, drivers::DisparityExtenderParams>(
      m, "DisparityExtender", "Disparity extender: steers to the farthest free direction.");
  bind_driver<CenterPid, drivers::CenterPidParams>(m, "CenterPid",
                                                   "PID center following: steers to the center between the walls.");
  nb::class_<CallbackDriver, Driver>(m, "CallbackDriver", "A driver written in Python.")
      .def(nb::init<nb::object>(), nb::arg("driver"),
           "`driver` has reset() and step(scan: LaserScan, state: VehicleState, dt) -> (speed, steering_angle, "
           "status). An exception ends the race.")
      .def("raise_error", &CallbackDriver::raise_error,
           "Raises the exception of the Python object, once. After an exception the car stops until the next reset.");
}

}  // namespace firstlap::bindings
