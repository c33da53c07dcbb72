// Many steps in one call: over the scans of a recording, and in a race with logging. Both release the GIL.
#include <chrono>
#include <cstdint>
#include <nanobind/nanobind.h>
#include <stdexcept>
#include <vector>

#include "arrays.hpp"
#include "firstlap/drivers/racer.hpp"
#include "firstlap/sim/race.hpp"
#include "modules.hpp"
#include "records.hpp"
#include "step_log.hpp"
#include "views.hpp"

namespace firstlap::bindings {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::size_t header_columns = column_count<LaserScan>;
constexpr std::size_t state_columns = column_count<VehicleState>;

void check_shapes(const Ranges& ranges, const Counts& sizes, const Rows& headers, const Rows& states,
                  const Values& dts) {
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

const Trace* trace_of(const Driver& driver) {
  const auto* racer = dynamic_cast<const Racer*>(&driver);
  return racer == nullptr ? nullptr : &racer->trace();
}

nb::dict replay(Driver& driver, const Ranges& ranges, const Counts& sizes, const Rows& headers, const Rows& states,
                const Values& dts) {
  check_shapes(ranges, sizes, headers, states, dts);
  StepLog log;
  {
    const nb::gil_scoped_release release;
    const float* next = ranges.data();
    for (std::size_t i = 0; i < sizes.shape(0); ++i) {
      const auto size = static_cast<std::size_t>(sizes.data()[i]);
      auto scan = from_row<LaserScan>(headers.data() + header_columns * i);
      scan.ranges = {next, size};
      const auto state = from_row<VehicleState>(states.data() + state_columns * i);
      const Clock::time_point begin = Clock::now();
      const StepResult result = driver.step(scan, state, dts.data()[i]);
      const std::chrono::duration<double, std::micro> spent = Clock::now() - begin;
      log.add(result, trace_of(driver), spent.count());
      next += size;
    }
  }
  return log.take();
}

// A driver that logs its inputs and results. For logged races, not for a car: it allocates.
class LoggedDriver final : public Driver {
 public:
  explicit LoggedDriver(Driver& driver) : driver_(driver) {}

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override {
    const Clock::time_point begin = Clock::now();
    const StepResult result = driver_.step(scan, state, dt);
    const std::chrono::duration<double, std::micro> spent = Clock::now() - begin;
    log_.add(result, trace_of(driver_), spent.count());
    ranges_.insert(ranges_.end(), scan.ranges.begin(), scan.ranges.end());
    sizes_.push_back(static_cast<std::int64_t>(scan.ranges.size()));
    append_row(scan, headers_);
    append_row(state, measured_);
    dts_.push_back(dt);
    return result;
  }
  void reset() noexcept override { driver_.reset(); }

  nb::dict take() {
    nb::dict columns = log_.take();
    columns["ranges"] = to_numpy(std::move(ranges_));
    columns["sizes"] = to_numpy(std::move(sizes_));
    columns["headers"] = to_numpy(std::move(headers_), header_columns);
    columns["measured"] = to_numpy(std::move(measured_), state_columns);
    columns["dt"] = to_numpy(std::move(dts_));
    ranges_ = {};
    sizes_ = {};
    headers_ = {};
    measured_ = {};
    dts_ = {};
    return columns;
  }

 private:
  Driver& driver_;
  StepLog log_;
  std::vector<float> ranges_;
  std::vector<std::int64_t> sizes_;
  std::vector<double> headers_, measured_, dts_;
};

// True pose and motion at each scan of a race, from scan `first` on.
nb::dict truth(const sim::Race& race, std::size_t first) {
  std::vector<double> pose, motion;
  const auto& path = race.result().path;
  for (std::size_t i = first; i < path.size(); ++i) {
    pose.insert(pose.end(), {path[i].x, path[i].y, path[i].yaw});
    motion.insert(motion.end(), {path[i].speed, path[i].yaw_rate});
  }
  nb::dict columns;
  columns["pose"] = to_numpy(std::move(pose), 3);
  columns["motion"] = to_numpy(std::move(motion), 2);
  return columns;
}

}  // namespace

void bind_replay(nb::module_& m) {
  m.def("replay", &replay, nb::arg("driver"), nb::arg("ranges").noconvert(), nb::arg("sizes"), nb::arg("headers"),
        nb::arg("states"), nb::arg("dts"),
        "Steps through N scans whose ranges are concatenated in `ranges`; sizes (N,). headers (N, 5) and states (N, 3) "
        "are rows of the tables of LaserScan and VehicleState; dts (N,) [s]. Returns columns, see "
        "firstlap.recordings.step_log.");
  nb::class_<LoggedDriver, Driver>(m, "LoggedDriver", "A driver that logs its inputs and results.")
      .def(nb::init<Driver&>(), nb::arg("driver"), nb::keep_alive<1, 2>())
      .def("take", &LoggedDriver::take,
           "Columns of the steps since the last call, as from `replay`, and the inputs: ranges (concatenated), sizes "
           "(N,), headers (N, 5), measured (N, 3), dt (N,).");
  m.def("truth", &truth, nb::arg("race"), nb::arg("first"),
        "pose (N, 3) x, y, yaw in the map and motion (N, 2) speed, yaw rate at each scan of a race, from scan `first` "
        "on.");
}

}  // namespace firstlap::bindings
