// The opponents: parameters, drivers and what they saw and thought; and drivers written in Python.
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
