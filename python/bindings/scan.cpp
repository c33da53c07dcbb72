// Which scans may be used.
#include <cstdint>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/scan_period.hpp"
#include "modules.hpp"

namespace firstlap::bindings {
namespace {

using Ranges = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

nb::tuple judge_scan(const Ranges& ranges, double angle_min, double angle_increment, double time_increment,
                     double range_min, double range_max, double period, double angle_max) {
  const LaserScan scan{angle_min, angle_increment, time_increment,
                       range_min, range_max,       {ranges.data(), ranges.shape(0)}};
  const ScanContext context{period, angle_max};
  const ScanJudgement judgement = judge(scan, context);
  nb::list remarks;
  if (judgement.usable()) {
    for (const std::string& remark : {explain_time(scan, context, judgement), explain_returns(judgement)})
      if (!remark.empty()) remarks.append(remark);
  }
  return nb::make_tuple(to_string(judgement.fault), explain_fault(scan, context, judgement), remarks);
}

Numpy<std::uint8_t, 1> returns(const Ranges& ranges, double range_min, double range_max) {
  const LaserScan scan{.range_min = range_min, .range_max = range_max, .ranges = {ranges.data(), ranges.shape(0)}};
  return column<std::uint8_t>(scan.ranges, [&](float r) { return is_return(scan, static_cast<double>(r)); });
}

}  // namespace

void bind_scan(nb::module_& m) {
  m.def("judge_scan", &judge_scan, nb::arg("ranges").noconvert(), nb::arg("angle_min"), nb::arg("angle_increment"),
        nb::arg("time_increment"), nb::arg("range_min"), nb::arg("range_max"), nb::arg("period"), nb::arg("angle_max"),
        "Fault by name ('none'), reason ('' where the scan may be used) and remarks. period: [s] between scans, 0 not "
        "known; angle_max: [rad] as its message states it, NaN not known.");
  m.def("scan_returns", &returns, nb::arg("ranges").noconvert(), nb::arg("range_min"), nb::arg("range_max"),
        "(N,) 1 where a range is a return, 0 for no return however it is spelled.");
  m.def("usable_sweep_time", &usable_sweep_time, nb::arg("time_increment"), nb::arg("beams"), nb::arg("period"),
        "[s] from the first beam to the last; 0 where time_increment [s] is negative, not finite, or makes it longer "
        "than period [s] allows (0: not known).");
  nb::class_<ScanPeriod>(m, "ScanPeriod", "How often scans come, learned so slowly that a lost one does not matter.")
      .def(nb::init<>())
      .def("learn", &ScanPeriod::learn, nb::arg("dt"), "dt: [s] since the scan before.")
      .def_prop_ro("seconds", &ScanPeriod::seconds, "[s] between scans; 0: not known.");
}

}  // namespace firstlap::bindings
