// The log of a sequence of steps, as columns: one scalar per scan, sequences concatenated, with their sizes.
#pragma once

#include <cstdint>
#include <nanobind/nanobind.h>
#include <tuple>
#include <vector>

#include "firstlap/drivers/trace.hpp"

namespace firstlap::bindings {

// Logged for every driver.
struct LoggedStep {
  StepResult result{};
  double microseconds = 0.0;

  static constexpr auto columns() {
    using C = LoggedStep;
    return std::tuple{
        Part{&C::result},
        Column{"microseconds", &C::microseconds, "us", "computing time of the step"},
    };
  }
};

// Logged for drivers with a trace.
struct LoggedTrace {
  double width = 0.0;
  double width_seen = 0.0;
  std::int64_t left_seen = 0;
  std::int64_t right_seen = 0;
  double clearance = 0.0;
  double ahead = 0.0;
  std::int64_t nearest = 0;
  Point2 lookahead{};

  static constexpr auto columns() {
    using C = LoggedTrace;
    return std::tuple{
        Column{"width", &C::width, "m", "remembered track width"},
        Column{"width_seen", &C::width_seen, "m", "median where both walls are visible; NaN if they never are"},
        Column{"left_seen", &C::left_seen, "", "number of rows of `left` that are from this scan (the first ones)"},
        Column{"right_seen", &C::right_seen, "", "number of rows of `right` that are from this scan (the first ones)"},
        Column{"clearance", &C::clearance, "m", "smallest distance of the path ahead to a wall; NaN without a path"},
        Column{"ahead", &C::ahead, "m", "length of the path ahead of the front axle"},
        Column{"nearest", &C::nearest, "", "row of `path` nearest to the front axle"},
        Column{"lookahead", &C::lookahead, "m", "x, y of the path point used by the steering; NaN without a path"},
    };
  }
};

struct LoggedWall {
  double x = 0.0, y = 0.0, age = 0.0;

  static constexpr auto columns() {
    using C = LoggedWall;
    return std::tuple{
        Column{"x", &C::x, "m", "of a sample, base_link"},
        Column{"y", &C::y, "m", "of a sample, base_link"},
        Column{"age", &C::age, "s", "since it was measured; 0: in this scan"},
    };
  }
};

struct LoggedLine {
  double x = 0.0, y = 0.0, width = 0.0;
  WallSupport support = WallSupport::none;

  static constexpr auto columns() {
    using C = LoggedLine;
    return std::tuple{
        Column{"x", &C::x, "m", "of a centerline point, base_link"},
        Column{"y", &C::y, "m", "of a centerline point, base_link"},
        Column{"width", &C::width, "m", "measured if both walls support the point, else estimated"},
        Column{"support", [](const C& p) { return static_cast<double>(p.support); }, "",
               "walls that support it: 0 none, 1 right, 2 left, 3 both"},
    };
  }
};

// Rows of all scans, concatenated.
template <class Row>
struct LoggedRows {
  std::vector<double> rows;
  std::vector<std::int64_t> sizes;
};

class StepLog {
 public:
  // `trace` is null for drivers without one; then the sequences stay empty.
  void add(const StepResult& result, const Trace* trace, double microseconds);

  // Moves the columns out and clears the log.
  [[nodiscard]] nanobind::dict take();

  // Calls `visit(name, sequence)`.
  template <class Visitor>
  void for_each_sequence(Visitor&& visit) {
    visit("left", left_);
    visit("right", right_);
    visit("line", line_);
    visit("path", path_);
  }

 private:
  void add_path(const Trace& trace, LoggedTrace& scalars);

  std::vector<LoggedStep> steps_;
  std::vector<LoggedTrace> traces_;
  LoggedRows<LoggedWall> left_, right_;
  LoggedRows<LoggedLine> line_;
  LoggedRows<TrajectoryPoint> path_;
};

}  // namespace firstlap::bindings
