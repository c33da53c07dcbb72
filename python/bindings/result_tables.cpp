// The tables of all output structs, for docs and logs.
#include <nanobind/nanobind.h>

#include "firstlap/drivers/center_pid.hpp"
#include "firstlap/drivers/disparity_extender.hpp"
#include "firstlap/drivers/follow_the_gap.hpp"
#include "firstlap/drivers/trace.hpp"
#include "firstlap/estimation/state_estimate.hpp"
#include "firstlap/localization/localizer.hpp"
#include "firstlap/sim/lap_search.hpp"
#include "firstlap/sim/race_result.hpp"
#include "modules.hpp"
#include "records.hpp"
#include "step_log.hpp"

namespace firstlap::bindings {
namespace {

nb::dict result_tables() {
  nb::dict tables;
  const auto add = [&]<class Struct>(const char* name, std::type_identity<Struct>) {
    tables[name] = column_list<Struct>();
  };
  add("LaserScan", std::type_identity<LaserScan>{});
  add("VehicleState", std::type_identity<VehicleState>{});
  add("SensorReading", std::type_identity<SensorReading>{});
  add("MotionEstimate", std::type_identity<MotionEstimate>{});
  add("StepResult", std::type_identity<StepResult>{});
  add("RaceResult", std::type_identity<sim::RaceResult>{});
  add("Lap", std::type_identity<sim::Lap>{});
  add("Contact", std::type_identity<sim::Contact>{});
  add("ObstacleSeen", std::type_identity<sim::ObstacleSeen>{});
  add("PathSample", std::type_identity<sim::PathSample>{});
  add("LapSearchResult", std::type_identity<sim::LapSearchResult>{});
  add("Trace", std::type_identity<Trace>{});
  add("Section", std::type_identity<Section>{});
  add("SplitCandidate", std::type_identity<SplitCandidate>{});
  add("WallSide", std::type_identity<WallSide>{});
  add("Centerline", std::type_identity<Centerline>{});
  add("TrajectoryPoint", std::type_identity<TrajectoryPoint>{});
  add("SteeringTerms", std::type_identity<SteeringTerms>{});
  add("FollowTheGap", std::type_identity<drivers::FollowTheGap::Trace>{});
  add("DisparityExtender", std::type_identity<drivers::DisparityExtender::Trace>{});
  add("CenterPid", std::type_identity<drivers::CenterPid::Trace>{});
  add("WallEstimate", std::type_identity<drivers::WallEstimate>{});
  add("Estimate", std::type_identity<localization::Estimate>{});
  add("LoggedStep", std::type_identity<LoggedStep>{});
  add("LoggedTrace", std::type_identity<LoggedTrace>{});
  StepLog log;
  log.for_each_sequence(
      [&]<class Row>(const char* name, const LoggedRows<Row>&) { add(name, std::type_identity<Row>{}); });
  return tables;
}

}  // namespace

void bind_result_tables(nb::module_& m) {
  m.def("result_tables", &result_tables,
        "The tables of scans, states, results and traces, and of the rows left, right, line and path of a log: "
        "{struct: [{name, unit, doc}]}.");
}

}  // namespace firstlap::bindings
