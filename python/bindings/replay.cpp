// Many steps in one call: over the scans of a recording, and over a race that is being logged. Both run without
// the interpreter's lock.
#include <chrono>
#include <cstdint>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <stdexcept>
#include <vector>

#include "arrays.hpp"
#include "firstlap/racer.hpp"
#include "firstlap/sim/race.hpp"
#include "rooms.hpp"
#include "step_log.hpp"

namespace firstlap::bindings {
namespace {

using Clock = std::chrono::steady_clock;
using Floats = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Sizes = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Column = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

constexpr std::size_t header_columns = 5;
constexpr std::size_t state_columns = 3;

void check_shapes(const Floats& ranges, const Sizes& sizes, const Rows& headers, const Rows& states,
                  const Column& dts) {
  const std::size_t n = sizes.shape(0);
  if (headers.shape(0) != n || headers.shape(1) != header_columns || states.shape(0) != n ||
      states.shape(1) != state_columns || dts.shape(0) != n)
    throw std::invalid_argument("for sizes (N,), headers must be (N, 5), states (N, 3), dts (N,)");
  std::size_t total = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (sizes.data()[i] < 0) throw std::invalid_argument("sizes must not be negative");
    total += static_cast<std::size_t>(sizes.data()[i]);
  }
  if (total != ranges.shape(0)) throw std::invalid_argument("sizes do not add up to the ranges");
}

nb::dict replay(Racer& racer, const Floats& ranges, const Sizes& sizes, const Rows& headers, const Rows& states,
                const Column& dts) {
  check_shapes(ranges, sizes, headers, states, dts);
  StepLog log;
  {
    const nb::gil_scoped_release release;
    const float* next = ranges.data();
    for (std::size_t i = 0; i < sizes.shape(0); ++i) {
      const auto size = static_cast<std::size_t>(sizes.data()[i]);
      const double* h = headers.data() + header_columns * i;
      const double* state = states.data() + state_columns * i;
      const LaserScan scan{h[0], h[1], h[2], h[3], h[4], {next, size}};
      const Clock::time_point begin = Clock::now();
      const StepResult result = racer.step(scan, {state[0], state[1], state[2]}, dts.data()[i]);
      const std::chrono::duration<double, std::micro> spent = Clock::now() - begin;
      log.add(result, &racer.trace(), spent.count());
      next += size;
    }
  }
  return log.take();
}

void put_state(const VehicleState& state, std::vector<double>& rows) {
  rows.insert(rows.end(), {state.speed, state.yaw_rate, state.steering_angle});
}

// Drives a race and keeps what every scan brought.
struct RaceLog {
  sim::Race& race;
  const Racer* racer;

  nb::dict advance(int scans) {
    StepLog log;
    std::vector<double> time, pose, measured, truth;
    std::vector<float> ranges;
    std::size_t beams = 1;
    {
      const nb::gil_scoped_release release;
      for (int i = 0; i < scans && !race.over(); ++i) {
        const std::size_t before = race.result().compute_times.size();
        race.advance();
        if (race.result().compute_times.size() == before) break;  // it ended between two scans
        const LaserScan scan = race.scan();
        const Pose2 where = race.pose();
        beams = scan.ranges.size();
        ranges.insert(ranges.end(), scan.ranges.begin(), scan.ranges.end());
        time.push_back(race.time());
        pose.insert(pose.end(), {where.x, where.y, where.yaw});
        put_state(race.measured(), measured);
        put_state(race.state(), truth);
        log.add(race.step_result(), racer == nullptr ? nullptr : &racer->trace(),
                static_cast<double>(race.result().compute_times.back()));
      }
    }
    nb::dict columns = log.take();
    columns["going"] = !race.over();
    columns["time"] = to_numpy(std::move(time));
    columns["pose"] = to_numpy(std::move(pose), 3);
    columns["measured"] = to_numpy(std::move(measured), state_columns);
    columns["truth"] = to_numpy(std::move(truth), state_columns);
    columns["ranges"] = to_numpy(std::move(ranges), beams);
    return columns;
  }
};

}  // namespace

void bind_replay(nb::module_& m) {
  m.def("replay", &replay, nb::arg("racer"), nb::arg("ranges").noconvert(), nb::arg("sizes"), nb::arg("headers"),
        nb::arg("states"), nb::arg("dts"),
        "Steps through N scans that stand end to end in `ranges`. headers (N, 5): angle_min, angle_increment, "
        "time_increment, range_min, range_max; states (N, 3): speed, yaw_rate, steering_angle. Returns columns, see "
        "firstlap.step_log.");
  nb::class_<RaceLog>(m, "RaceLog", "Drives a race and keeps what every scan brought.")
      .def(
          "__init__",
          [](RaceLog* self, sim::Race& race, const Racer* racer) {
            new (self) RaceLog{race, racer};
          },
          nb::arg("race"), nb::arg("racer").none(), nb::keep_alive<1, 2>(), nb::keep_alive<1, 3>(),
          "racer: the race's driver where it is one, for its intermediate results; else None.")
      .def("advance", &RaceLog::advance, nb::arg("scans"),
           "Drives for so many scan periods at most; columns as of `replay`, and time, pose, measured, truth, ranges; "
           "and "
           "whether it is still going.");
}

}  // namespace firstlap::bindings
