#include "firstlap/planning/minimum_curvature.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/planning/trajectory.hpp"

namespace firstlap {
namespace {

constexpr std::size_t min_control_points = 4;  // control points, two of which lie on the car's arc
constexpr double overshoot = 1.6;              // over-relaxation factor: converges in a third of the passes

// Unit normal, to the left.
Point2 normal_at(const Buffer<Point2>& points, std::size_t i) noexcept {
  const Point2& a = points[i > 0 ? i - 1 : 0];
  const Point2& b = points[std::min(i + 1, points.size() - 1)];
  const double length = std::max(distance(a, b), 1e-9);
  return {(a.y - b.y) / length, (b.x - a.x) / length};
}

std::size_t nearest_to_base_link(const Buffer<Point2>& points) noexcept {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (norm(points[i].x, points[i].y) < norm(points[best].x, points[best].y)) best = i;
  return best;
}

void place(ControlPoint& control_point) noexcept {
  control_point.at = {control_point.on_line.x + control_point.offset * control_point.normal.x,
                      control_point.on_line.y + control_point.offset * control_point.normal.y};
}

// The smoothed centerline, with the clearance [m] that the path keeps from the walls.
struct Corridor {
  const Buffer<CenterlinePoint>& line;
  const Buffer<Point2>& points;
  double clearance;
};

// Limits of the offset at point i, so that the path keeps its clearance over `reach` [m] to both sides.
void limit_offsets(const Corridor& corridor, std::size_t i, double reach, ControlPoint& control_point) noexcept {
  const Buffer<Point2>& points = corridor.points;
  control_point.low = -1e9;
  control_point.high = 1e9;
  const auto narrow = [&](std::size_t j) {
    const Point2 normal = normal_at(corridor.points, j);
    const Point2& on_line = corridor.points[j];
    const CenterlinePoint& middle = corridor.line[j];
    const double beside = normal.x * (on_line.x - middle.x) + normal.y * (on_line.y - middle.y);
    const double slack = std::max(0.0, clearance_at(middle) - corridor.clearance);
    control_point.low = std::max(control_point.low, -slack - beside);
    control_point.high = std::min(control_point.high, slack - beside);
  };
  narrow(i);
  for (std::size_t j = i; j > 0 && distance(points[j - 1], points[i]) <= reach; --j) narrow(j - 1);
  for (std::size_t j = i + 1; j < points.size() && distance(points[j], points[i]) <= reach; ++j) narrow(j);
  control_point.low = std::min(control_point.low, 0.0);
  control_point.high = std::max(control_point.high, 0.0);
}

// The bending of the path as a function of one control point's position: gradient and stiffness.
class Bending {
 public:
  explicit Bending(const Buffer<ControlPoint>& control_points) noexcept : control_points_(control_points) {}

  // Adds the change of direction per length at control point `middle`; `lever` is its derivative with respect to the
  // offset.
  void add(std::size_t middle, double lever) noexcept {
    const ControlPoint& a = control_points_[middle - 1];
    const ControlPoint& b = control_points_[middle];
    const ControlPoint& c = control_points_[middle + 1];
    const double weight = 2.0 / (b.step + c.step);
    const Point2 turn{(c.at.x - b.at.x) / c.step - (b.at.x - a.at.x) / b.step,
                      (c.at.y - b.at.y) / c.step - (b.at.y - a.at.y) / b.step};
    pull_ = {pull_.x + weight * lever * turn.x, pull_.y + weight * lever * turn.y};
    stiffness_ += weight * lever * lever;
  }

  // Offset [m] along `normal` from the position of least bending.
  [[nodiscard]] double excess(Point2 normal) const noexcept {
    return (pull_.x * normal.x + pull_.y * normal.y) / stiffness_;
  }

 private:
  const Buffer<ControlPoint>& control_points_;
  Point2 pull_{};
  double stiffness_ = 0.0;
};

// Minimizes the integral of squared curvature by relaxation. The first two control points are fixed.
void relax(int passes, Buffer<ControlPoint>& control_points) noexcept {
  const std::size_t n = control_points.size();
  for (int pass = 0; pass < passes; ++pass) {
    for (std::size_t i = 1; i < n; ++i)
      control_points[i].step = std::max(distance(control_points[i - 1].at, control_points[i].at), 1e-3);
    for (std::size_t i = 2; i < n; ++i) {
      ControlPoint& control_point = control_points[i];
      Bending bending(control_points);
      bending.add(i - 1, 1.0 / control_point.step);
      if (i + 1 < n) bending.add(i, -1.0 / control_point.step - 1.0 / control_points[i + 1].step);
      if (i + 2 < n) bending.add(i + 1, 1.0 / control_points[i + 1].step);
      const double move = bending.excess(control_point.normal);
      control_point.offset = std::clamp(control_point.offset - overshoot * move, control_point.low, control_point.high);
      place(control_point);
    }
  }
}

// The first two control points, on the arc that the car is driving.
void start_on_arc(const PathConditions& conditions, const MinimumCurvatureParams& params,
                  Buffer<ControlPoint>& control_points) noexcept {
  const auto on_arc = [&](double x) {
    ControlPoint control_point;
    control_point.at = {x, 0.5 * conditions.curvature * x * x};
    return control_point;
  };
  control_points.push(on_arc(params.bend_lead - params.bend_spacing));
  control_points.push(on_arc(params.bend_lead));
}

// The other control points, evenly spaced along the smoothed centerline from the car on.
void continue_on_line(const Corridor& corridor, const MinimumCurvatureParams& params,
                      Buffer<ControlPoint>& control_points) noexcept {
  const Buffer<Point2>& points = corridor.points;
  const std::size_t foot = nearest_to_base_link(points);
  double left = 0.0;  // [m] of line ahead
  for (std::size_t i = foot + 1; i < points.size(); ++i) left += distance(points[i], points[i - 1]);
  double along = -params.bend_lead;  // [m] since the last control point
  for (std::size_t i = foot + 1; i < points.size(); ++i) {
    const double piece = distance(points[i], points[i - 1]);
    along += piece;
    left -= piece;
    if (along < params.bend_spacing) continue;
    along -= params.bend_spacing;
    ControlPoint control_point{.on_line = points[i], .normal = normal_at(points, i)};
    limit_offsets(corridor, i, 0.5 * params.bend_spacing, control_point);
    // The track beyond the end of the line is unknown: toward the end the path returns to the line.
    const double share = std::min(1.0, left / params.bend_sight);
    control_point.low *= share;
    control_point.high *= share;
    place(control_point);
    if (!control_points.push(control_point)) return;
  }
}

}  // namespace

bool minimum_curvature_path(const Buffer<CenterlinePoint>& line, const PathConditions& conditions,
                            const MinimumCurvatureParams& params, Buffer<ControlPoint>& control_points,
                            Buffer<Point2>& points) noexcept {
  control_points.clear();
  if (params.bend_passes == 0 || points.size() < min_control_points) return false;
  start_on_arc(conditions, params, control_points);
  continue_on_line({line, points, conditions.clearance}, params, control_points);
  if (control_points.size() < min_control_points) return false;
  relax(params.bend_passes, control_points);
  points.clear();
  for (const ControlPoint& control_point : control_points) points.push(control_point.at);
  return true;
}

}  // namespace firstlap
