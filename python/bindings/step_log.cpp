#include "step_log.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

#include "arrays.hpp"

namespace firstlap::bindings {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t side_columns = 3;
constexpr std::size_t line_columns = 4;
constexpr std::size_t path_columns = 6;

// Median width where both walls are seen; NaN where they never are.
double width_seen(const Centerline& line) {
  std::vector<double> widths;
  for (const CenterlinePoint& p : line.points)
    if (p.support == Support::both) widths.push_back(p.width);
  if (widths.empty()) return unknown;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

}  // namespace

void StepLog::add(const StepResult& result, const Trace* trace, double microseconds) {
  speed_.push_back(result.command.speed);
  steering_angle_.push_back(result.command.steering_angle);
  status_.push_back(static_cast<std::uint8_t>(result.status));
  microseconds_.push_back(microseconds);
  if (trace == nullptr) return;
  add_side(trace->walls.left, left_, left_seen_);
  add_side(trace->walls.right, right_, right_seen_);
  add_line(trace->line);
  add_path(*trace);
  width_.push_back(trace->width);
  width_seen_.push_back(width_seen(trace->line));
}

void StepLog::add_side(const WallSide& side, Sequence& into, std::vector<std::int64_t>& seen) {
  seen.push_back(static_cast<std::int64_t>(side.seen));
  for (std::size_t i = 0; i < side.size(); ++i) {
    const Point2 p = side.at(i);
    into.rows.insert(into.rows.end(), {p.x, p.y, static_cast<double>(side.age[i])});
  }
  into.sizes.push_back(static_cast<std::int64_t>(side.size()));
}

void StepLog::add_line(const Centerline& line) {
  for (const CenterlinePoint& p : line.points)
    line_.rows.insert(line_.rows.end(), {p.x, p.y, p.width, static_cast<double>(p.support)});
  line_.sizes.push_back(static_cast<std::int64_t>(line.points.size()));
}

void StepLog::add_path(const Trace& trace) {
  for (const TrajectoryPoint& p : trace.path)
    path_.rows.insert(path_.rows.end(), {p.s, p.x, p.y, p.yaw, p.curvature, p.velocity});
  path_.sizes.push_back(static_cast<std::int64_t>(trace.path.size()));
  const bool known = trace.nearest < trace.path.size();
  nearest_.push_back(known ? static_cast<std::int64_t>(trace.nearest) : 0);
  ahead_.push_back(known ? trace.path.back().s - trace.path[trace.nearest].s : 0.0);
  clearance_.push_back(known ? trace.clearance : unknown);
  lookahead_.push_back(known ? trace.lookahead.x : unknown);
  lookahead_.push_back(known ? trace.lookahead.y : unknown);
}

nanobind::dict StepLog::take() {
  nb::dict columns;
  const auto put = [&](const char* name, auto& values) { columns[name] = to_numpy(std::move(values)); };
  const auto put_rows = [&](const char* name, const char* sizes, Sequence& sequence, std::size_t width) {
    columns[name] = to_numpy(std::move(sequence.rows), width);
    columns[sizes] = to_numpy(std::move(sequence.sizes));
  };
  put("speed", speed_);
  put("steering_angle", steering_angle_);
  put("status", status_);
  put("microseconds", microseconds_);
  put("width", width_);
  put("width_seen", width_seen_);
  put("left_seen", left_seen_);
  put("right_seen", right_seen_);
  put("clearance", clearance_);
  put("ahead", ahead_);
  put("nearest", nearest_);
  columns["lookahead"] = to_numpy(std::move(lookahead_), 2);
  put_rows("left", "left_size", left_, side_columns);
  put_rows("right", "right_size", right_, side_columns);
  put_rows("line", "line_size", line_, line_columns);
  put_rows("path", "path_size", path_, path_columns);
  *this = StepLog{};
  return columns;
}

}  // namespace firstlap::bindings
