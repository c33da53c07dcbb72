// Scans and states as inputs of drivers, and the validity of scans.
#include <nanobind/stl/string.h>
#include <string>
#include <utility>

#include "arrays.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/scan_period.hpp"
#include "firstlap/sim/lidar.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "records.hpp"

namespace firstlap::bindings {
namespace {

nb::tuple judge_scan(const BoundScan& bound, double period, double angle_max) {
  const LaserScan& scan = bound.scan();
  const ScanContext context{period, angle_max};
  const ScanCheck check = check_scan(scan, context);
  nb::list remarks;
  if (check.usable()) {
    for (const std::string& remark : {describe_time(scan, context, check), describe_returns(check)})
      if (!remark.empty()) remarks.append(remark);
  }
  return nb::make_tuple(to_string(check.fault), describe_fault(scan, context, check), remarks);
}

Numpy<bool, 1> returns(const BoundScan& bound) {
  const LaserScan& scan = bound.scan();
  return flags(scan.ranges, [&](float r) { return is_return(scan, static_cast<double>(r)); });
}

// Header defaults are those of the default car's LiDAR, without sweep time.
void bind_laser_scan(nb::module_& m) {
  const sim::LidarParams lidar;
  nb::class_<BoundScan> bound(m, "LaserScan",
                              "One sweep of a planar LiDAR, as sensor_msgs/LaserScan. The seam between first and last "
                              "beam may be anywhere, and the LiDAR may rotate either way. A range that is not finite, "
                              "or not between range_min and range_max, is no return (REP 117).");
  bound
      .def(
          "__init__",
          [](BoundScan* self, Ranges ranges, double angle_min, double angle_increment, double time_increment,
             double range_min, double range_max) {
            new (self)
                BoundScan(std::move(ranges), {angle_min, angle_increment, time_increment, range_min, range_max, {}});
          },
          nb::arg("ranges").noconvert(), nb::arg("angle_min") = lidar.angle_min(),
          nb::arg("angle_increment") = lidar.angle_increment(), nb::arg("time_increment") = 0.0,
          nb::arg("range_min") = lidar.range_min, nb::arg("range_max") = lidar.range_max,
          "ranges: (beams,) [m], float32 and contiguous; not copied. Raises TypeError for other arrays.")
      .def_prop_ro("ranges", &BoundScan::ranges, "(beams,) [m]")
      .def_prop_ro(
          "header", [](const BoundScan& self) { return as_values(self.scan()); },
          nb::for_getter(nb::sig("def header(self) -> tuple[float, float, float, float, float]")),
          "All fields but the ranges, in the order of the table.")
      .def("returns", &returns, "(beams,) bool: which beams have a return.")
      .def_static("columns", &column_list<LaserScan>,
                  "The table of the header: a list of dicts with name, unit and doc.");
  def_columns<LaserScan>(bound, &BoundScan::scan);
}

}  // namespace

void bind_scan(nb::module_& m) {
  bind_laser_scan(m);
  bind_record<VehicleState>(m, "VehicleState", "State measured by the car at the end of the sweep.");
  bind_record<SensorReading>(m, "SensorReading", "Measurements of the car's own sensors. NaN: not measured.");
  m.def("judge_scan", &judge_scan, nb::arg("scan"), nb::arg("period"), nb::arg("angle_max"),
        "Returns the fault by name ('none'), the reason ('' if the scan is usable) and remarks. period: [s] between "
        "scans, 0 if unknown; angle_max: [rad] as in the message, NaN if unknown.");
  m.def("usable_sweep_time", &usable_sweep_time, nb::arg("time_increment"), nb::arg("beams"), nb::arg("period"),
        "[s] from the first beam to the last; 0 if time_increment [s] is negative, not finite, or gives a longer sweep "
        "than period [s] allows (0: unknown).");
  nb::class_<ScanPeriod>(m, "ScanPeriod", "The scan period, low-pass filtered so that a lost scan has little effect.")
      .def(nb::init<>())
      .def("learn", &ScanPeriod::learn, nb::arg("dt"), "dt: [s] since the previous scan.")
      .def_prop_ro("seconds", &ScanPeriod::seconds, "[s] between scans; 0: unknown.");
}

}  // namespace firstlap::bindings
