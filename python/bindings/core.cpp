// The map-less method: parameters, step and trace.

#include "firstlap/drivers/racer.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "tables.hpp"
#include "to_python.hpp"

namespace firstlap::bindings {
namespace {

nb::tuple step(Driver& driver, const BoundScan& scan, const VehicleState& state, double dt) {
  StepResult result;
  {
    const nb::gil_scoped_release release;
    result = driver.step(scan.scan(), state, dt);
  }
  return as_tuple(result);
}

}  // namespace

void bind_core(nb::module_& m) {
  nb::list names;
  for (const Status status : statuses) names.append(to_string(status));
  m.attr("STATUSES") = nb::tuple(names);
  bind_sections<Params>(m, "Params", "All parameters of the map-less method, in sections.");
  nb::class_<Driver>(m, "Driver", "Scan and state in, command out.")
      .def("reset", &Driver::reset, "Clears the memory of all earlier scans.")
      .def("step", &step, nb::arg("scan"), nb::arg("state"), nb::arg("dt"),
           "Returns speed [m/s], steering angle [rad] and status. dt: [s] since the previous scan. Releases the GIL.");
  nb::class_<Racer, Driver>(m, "Racer", "The map-less method: one scan in, one command out.")
      .def(nb::init<const Params&>(), nb::arg("params"), "Raises ValueError with field, value and range.")
      .def("set_params", &Racer::set_params, nb::arg("params"),
           "Changes the parameters while driving. Raises ValueError as the constructor does; then the old ones stay.")
      .def(
          "trace", [](const Racer& racer) { return as_dict(racer.trace()); },
          "Intermediate results of the last step, as numpy arrays in base_link; see docs/results-format.md.");
}

}  // namespace firstlap::bindings
