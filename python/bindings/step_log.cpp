#include "step_log.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "to_python.hpp"

namespace firstlap::bindings {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// Median width where both walls are visible; NaN if they never are.
double width_seen(const Centerline& line) {
  std::vector<double> widths;
  for (const CenterlinePoint& p : line.points)
    if (p.support == WallSupport::both) widths.push_back(p.width);
  if (widths.empty()) return unknown;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

void add_side(const WallSide& side, LoggedRows<LoggedWall>& into) {
  for (std::size_t i = 0; i < side.size(); ++i) {
    const Point2 p = side.at(i);
    append_row(LoggedWall{p.x, p.y, static_cast<double>(side.age[i])}, into.rows);
  }
  into.sizes.push_back(static_cast<std::int64_t>(side.size()));
}

void add_line(const Centerline& line, LoggedRows<LoggedLine>& into) {
  for (const CenterlinePoint& p : line.points) append_row(LoggedLine{p.x, p.y, p.width, p.support}, into.rows);
  into.sizes.push_back(static_cast<std::int64_t>(line.points.size()));
}

}  // namespace

void StepLog::add(const StepResult& result, const Trace* trace, double microseconds) {
  steps_.push_back({result, microseconds});
  if (trace == nullptr) return;
  // Without a usable scan, the trace holds no walls of this step.
  const bool looked = result.status != Status::bad_scan && result.status != Status::bad_state;
  static const LocalWalls nothing;
  const LocalWalls& walls = looked ? trace->walls : nothing;
  add_side(walls.left, left_);
  add_side(walls.right, right_);
  add_line(trace->line, line_);
  LoggedTrace scalars;
  scalars.width = trace->width;
  scalars.width_seen = width_seen(trace->line);
  scalars.left_seen = static_cast<std::int64_t>(walls.left.seen);
  scalars.right_seen = static_cast<std::int64_t>(walls.right.seen);
  add_path(*trace, scalars);
  traces_.push_back(scalars);
}

void StepLog::add_path(const Trace& trace, LoggedTrace& scalars) {
  for (const TrajectoryPoint& p : trace.path) append_row(p, path_.rows);
  path_.sizes.push_back(static_cast<std::int64_t>(trace.path.size()));
  const bool known = trace.nearest < trace.path.size();
  scalars.nearest = known ? static_cast<std::int64_t>(trace.nearest) : 0;
  scalars.ahead = known ? trace.path.back().s - trace.path[trace.nearest].s : 0.0;
  scalars.clearance = known ? trace.clearance : unknown;
  scalars.lookahead = known ? Point2{trace.lookahead.x, trace.lookahead.y} : Point2{unknown, unknown};
}

nanobind::dict StepLog::take() {
  nb::dict columns;
  columns.update(nb::cast<nb::dict>(from_sequence(steps_)));
  columns.update(nb::cast<nb::dict>(from_sequence(traces_)));
  for_each_sequence([&]<class Row>(const char* name, LoggedRows<Row>& sequence) {
    columns[name] = to_numpy(std::move(sequence.rows), column_count<Row>);
    columns[(std::string(name) + "_size").c_str()] = to_numpy(std::move(sequence.sizes));
  });
  *this = StepLog{};
  return columns;
}

}  // namespace firstlap::bindings
