#include "firstlap/planning/centerline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

// Numerics of tracing a zero set on which both distances are equal.
constexpr int newton_steps = 8;
constexpr double newton_reach = 0.5;   // [m] maximum Newton step
constexpr double found = 0.2;          // [m] maximum difference of the distances at the first point
constexpr double on_line = 0.01;       // [m] difference that needs no correction
constexpr double share_of_step = 0.7;  // maximum correction as a share of the spacing
constexpr double flat = 0.2;           // slope of the difference, 2 between two walls, below which no step is taken
constexpr double pocket = 0.3;         // slope below which the heading is kept: both walls are in the same direction

// The walls as seen from one point.
struct WallView {
  double right = 0.0;  // [m] measured or estimated distance
  double left = 0.0;
  WallSupport support = WallSupport::none;
  Point2 right_sample;
  Point2 left_sample;
  Point2 gradient;         // of (right - left): toward the left wall
  double clearance = 0.0;  // [m] to the nearer visible wall
  bool wide = false;       // see CenterlinePoint
  bool in_sight = false;   // in free space between the lines of sight past two visible ends

  [[nodiscard]] double imbalance() const noexcept { return right - left; }
  [[nodiscard]] double slope() const noexcept { return norm(gradient.x, gradient.y); }
};

struct SideView {
  double distance = 0.0;  // [m]; 0: no wall
  bool representative = false;
  bool counts = false;  // its distance is measured, or estimated from a wall of its own
  Point2 sample;        // nearest point of the wall
  Point2 outward;       // at a visible end, direction of the wall into the occluded area
  Sight sight;          // past that end
};

// Nearest point to (x, y) on the segment between two neighboring samples.
Point2 nearest_between(Point2 a, Point2 b, double x, double y) noexcept {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  if (length2 < 1e-12) return a;
  const double t = std::clamp(((x - a.x) * dx + (y - a.y) * dy) / length2, 0.0, 1.0);
  return {a.x + t * dx, a.y + t * dy};
}

// A wall supports a point unless its nearest sample is a visible end that the point has passed.
SideView view_side(const WallSide& side, const CenterlineParams& params, double x, double y) noexcept {
  SideView view;
  if (side.size() == 0) return view;
  const Nearest nearest = nearest_sample(side, x, y);
  const Point2 sample = side.at(nearest.index);
  view.sample = sample;
  view.distance = nearest.distance;
  view.outward = side.outward[nearest.index];
  view.sight = side.sight[nearest.index];
  const double beyond = (x - sample.x) * view.outward.x + (y - sample.y) * view.outward.y;
  view.representative = beyond <= params.end_slack * nearest.distance;
  for (const std::size_t k : {nearest.index - 1, nearest.index + 1}) {
    if (k >= side.size()) continue;
    const Point2 next = side.at(k);
    if (norm(next.x - sample.x, next.y - sample.y) > params.wall_step) continue;
    const Point2 between = nearest_between(sample, next, x, y);
    const double d = norm(x - between.x, y - between.y);
    if (d >= view.distance) continue;
    view.distance = d;
    view.sample = between;
  }
  return view;
}

// Past the end of a wall the line of sight bounds the occluded area, in which the wall continues. Returns the point of
// that area nearest to (x, y).
Point2 nearest_in_shadow(const SideView& hidden, double x, double y) noexcept {
  const double sx = static_cast<double>(hidden.sight.x);
  const double sy = static_cast<double>(hidden.sight.y);
  const double dx = x - hidden.sample.x;
  const double dy = y - hidden.sample.y;
  const double along = std::max(0.0, sx * dx + sy * dy);
  const double inside = (sx * dy - sy * dx) * static_cast<double>(hidden.sight.shadow);
  if (inside > 0.0 && along > 0.0) return {x, y};
  return {hidden.sample.x + along * sx, hidden.sample.y + along * sy};
}

// Whether (x, y) lies in free space, outside the occluded area behind the nearest visible end.
bool lies_in_sight(const SideView& side, double x, double y) noexcept {
  if (side.sight.shadow == 0.0F) return false;
  const Point2 shadow = nearest_in_shadow(side, x, y);
  return norm(x - shadow.x, y - shadow.y) > 0.0;
}

// Estimates the distance of an occluded wall: the track width minus the distance of the visible wall, but at most the
// distance of its visible end. At an apex the track is wider than along it: the occluded wall is not closer than the
// line of sight past its end either, so that the centerline goes around the apex, not along the outer wall. This
// holds if the track continues past this end or if the other wall curves across it; elsewhere a piece of wall may be
// missing, and the track width is used. Moves `hidden.sample` to the point that gives the distance; returns false if
// the track width gives it.
bool estimate(SideView& hidden, const SideView& seen, Point2 at, double width,
              const TrackWidthParams& params) noexcept {
  const auto [x, y] = at;
  const double end_distance = hidden.distance;
  hidden.distance = width - seen.distance;
  if (end_distance <= 0.0) return false;
  const Point2 end = hidden.sample;
  const double beyond = (x - end.x) * hidden.outward.x + (y - end.y) * hidden.outward.y;
  const double across = std::abs(hidden.outward.x * (x - seen.sample.x) + hidden.outward.y * (y - seen.sample.y)) /
                        std::max(seen.distance, 1e-6);
  const double crossing = std::min(1.0, params.bend_gain * across);
  const double apex = crossing * std::clamp(1.0 - beyond / width, 0.0, 1.0);
  hidden.distance = width * (1.0 + params.apex_width * apex) - seen.distance;
  if (end_distance <= hidden.distance) {
    hidden.distance = end_distance;
    return true;
  }
  if (hidden.sight.shadow == 0.0F) return false;
  const Point2 shadow = nearest_in_shadow(hidden, x, y);
  const double free = std::min(norm(x - shadow.x, y - shadow.y), params.width_max - seen.distance);
  const double share = std::max(crossing, hidden.sight.track_continues ? params.way_on_share : 0.0);
  if (free <= hidden.distance || share <= 0.0) return false;
  hidden.distance += share * (free - hidden.distance);
  hidden.sample = shadow;
  return true;
}

// Gradient of (right - left) at a point.
Point2 gradient_at(Point2 at, const SideView& right, const SideView& left) noexcept {
  const auto [x, y] = at;
  const double inverse_right = right.counts && right.distance > 1e-6 ? 1.0 / right.distance : 0.0;
  const double inverse_left = left.counts && left.distance > 1e-6 ? 1.0 / left.distance : 0.0;
  // The estimated side moves with the visible one, so the visible side's part of the gradient counts twice.
  const double weight_right = left.counts ? 1.0 : 2.0;
  const double weight_left = right.counts ? 1.0 : 2.0;
  return {weight_right * (x - right.sample.x) * inverse_right - weight_left * (x - left.sample.x) * inverse_left,
          weight_right * (y - right.sample.y) * inverse_right - weight_left * (y - left.sample.y) * inverse_left};
}

// Distance [m] to the nearer of the sides that count; of both if none does.
double nearer_wall(const SideView& right, const SideView& left) noexcept {
  constexpr double none = std::numeric_limits<double>::infinity();
  return std::min(right.counts || !left.counts ? right.distance : none,
                  left.counts || !right.counts ? left.distance : none);
}

WallSupport support_by(const SideView& right, const SideView& left) noexcept {
  if (right.representative) return left.representative ? WallSupport::both : WallSupport::right;
  return left.representative ? WallSupport::left : WallSupport::none;
}

WallView view_walls(const LocalWalls& walls, Point2 at, double width, const LineLimits& limits) noexcept {
  const TrackWidthParams& params = limits.width;
  SideView right = view_side(walls.right, limits.line, at.x, at.y);
  SideView left = view_side(walls.left, limits.line, at.x, at.y);
  WallView view;
  view.wide = right.representative && left.representative && right.distance + left.distance > params.width_max;
  if (view.wide) (right.distance > left.distance ? right : left).representative = false;
  view.support = support_by(right, left);
  right.counts = right.representative || (left.representative && estimate(right, left, at, width, params));
  left.counts = left.representative || (right.representative && estimate(left, right, at, width, params));
  if (view.support == WallSupport::none)
    view.in_sight = lies_in_sight(right, at.x, at.y) && lies_in_sight(left, at.x, at.y);
  view.right_sample = right.sample;
  view.left_sample = left.sample;
  view.right = right.distance;
  view.left = left.distance;
  view.clearance = nearer_wall(right, left);
  view.gradient = gradient_at(at, right, left);
  return view;
}

// Bounding box of points, to skip most comparisons.
class Box {
 public:
  void add(double x, double y) noexcept {
    x_min_ = std::min(x_min_, x);
    x_max_ = std::max(x_max_, x);
    y_min_ = std::min(y_min_, y);
    y_max_ = std::max(y_max_, y);
  }
  // Whether (x, y) is in the box or within `margin` of it.
  [[nodiscard]] bool contains(double x, double y, double margin) const noexcept {
    return x >= x_min_ - margin && x <= x_max_ + margin && y >= y_min_ - margin && y <= y_max_ + margin;
  }

 private:
  double x_min_ = std::numeric_limits<double>::infinity();
  double x_max_ = -std::numeric_limits<double>::infinity();
  double y_min_ = std::numeric_limits<double>::infinity();
  double y_max_ = -std::numeric_limits<double>::infinity();
};

// A point of the line and the walls as seen from it.
struct LinePoint {
  Point2 at;
  WallView view;

  // Unit vector along the line, forward (+1) or backward (-1).
  [[nodiscard]] Point2 along(double direction) const noexcept {
    return {direction * view.gradient.y / view.slope(), -direction * view.gradient.x / view.slope()};
  }
};

class Tracer {
 public:
  Tracer(const LineScene& scene, const LineLimits& limits) noexcept
      : walls_(scene.walls),
        trail_(scene.trail),
        limits_(limits),
        params_(limits.line),
        width_(scene.width),
        half_car_(0.5 * limits.car.width),
        loop_points_(static_cast<std::size_t>(params_.loop_length / params_.spacing)),
        meeting_distance_(params_.same_way * scene.width) {
    for (const TrailPoint& p : trail_) trail_box_.add(p.x, p.y);
  }

  // Projects a point onto the centerline by Newton steps; false if that fails.
  bool project(LinePoint& point) const noexcept {
    for (int i = 0; i < newton_steps; ++i) {
      look(width_, point);
      if (point.view.support == WallSupport::none) return false;
      if (!correct(newton_reach, point)) return false;
    }
    look(width_, point);
    return point.view.support != WallSupport::none && std::abs(point.view.imbalance()) < found;
  }

  // Traces the centerline from `point` over `length` [m], forward (+1) or backward (-1).
  LineEnd trace(LinePoint point, double direction, double length, Buffer<CenterlinePoint>& out) const noexcept {
    LocalWidth width(width_, limits_.width);
    Point2 heading = point.along(direction);
    const WallView& view = point.view;
    double unsupported = 0.0;  // [m] since the last point supported by a wall
    double farthest = 0.0;     // [m] maximum of `unsupported`
    for (double s = 0.0; s <= length; s += params_.spacing) {
      if (s > 0.0) advance(direction, width.value(), point, heading);
      unsupported = view.support == WallSupport::none ? unsupported + params_.spacing : 0.0;
      if (unsupported <= params_.spacing) farthest = view.in_sight ? std::max(width_, params_.sight_length) : width_;
      if (unsupported > farthest) return LineEnd::end_of_view;
      if (view.clearance < half_car_) return LineEnd::too_narrow;
      if (direction > 0.0 && (runs_against_trail(point.at, heading, s) || meets_itself(out, point.at)))
        return LineEnd::turns_back;
      const double w = measure(view, width);
      if (!out.push({point.at.x, point.at.y, w, view.support, view.right_sample, view.left_sample, view.wide})) break;
    }
    return LineEnd::length;
  }

 private:
  void look(double width, LinePoint& point) const noexcept {
    point.view = view_walls(walls_, point.at, width, limits_);
  }

  // One spacing along `heading`, then onto the line. Between two visible ends, as where the track widens on both sides,
  // the line goes straight on; the heading is also kept if both walls are in the same direction (a dead end, a pocket).
  void advance(double direction, double width, LinePoint& point, Point2& heading) const noexcept {
    point.at.x += params_.spacing * heading.x;
    point.at.y += params_.spacing * heading.y;
    look(width, point);
    if (point.view.support == WallSupport::none) return;
    if (std::abs(point.view.imbalance()) > on_line) {
      correct(share_of_step * params_.spacing, point);
      look(width, point);
    }
    if (point.view.slope() >= pocket) turn(point.along(direction), heading);
  }

  // One Newton step toward equal distances, at most `reach` [m].
  static bool correct(double reach, LinePoint& point) noexcept {
    const double slope = point.view.slope();
    if (slope < flat) return false;
    const double step = std::clamp(-point.view.imbalance() / slope, -reach, reach);
    point.at.x += step * point.view.gradient.x / slope;
    point.at.y += step * point.view.gradient.y / slope;
    return true;
  }

  // Turns the heading to `along`, by at most `turn_step`.
  void turn(Point2 along, Point2& heading) const noexcept {
    const double limit = params_.turn_step;
    const double angle =
        std::clamp(std::atan2(heading.x * along.y - heading.y * along.x, heading.x * along.x + heading.y * along.y),
                   -limit, limit);
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    heading = {c * heading.x - s * heading.y, s * heading.x + c * heading.y};
  }

  // [m] The width at a point, measured between two walls, else estimated.
  [[nodiscard]] double measure(const WallView& view, LocalWidth& width) const noexcept {
    const bool pair = view.support == WallSupport::both;
    if (pair)
      width.observe(view.right + view.left);
    else
      width.miss(params_.spacing);
    return pair ? view.right + view.left : width.value();
  }

  [[nodiscard]] bool is_near(double dx, double dy) const noexcept {
    return dx * dx + dy * dy < meeting_distance_ * meeting_distance_;
  }

  // A line around the end of a wall may return to its start.
  [[nodiscard]] bool meets_itself(const Buffer<CenterlinePoint>& line, Point2 at) const noexcept {
    for (std::size_t i = 0; i + loop_points_ < line.size(); i += 2)
      if (is_near(at.x - line[i].x, at.y - line[i].y)) return true;
    return false;
  }

  [[nodiscard]] bool runs_against_trail(Point2 at, Point2 heading, double s) const noexcept {
    if (s < params_.trail_free || !trail_box_.contains(at.x, at.y, meeting_distance_)) return false;
    const auto along = [&](double yaw) { return heading.x * std::cos(yaw) + heading.y * std::sin(yaw); };
    return std::any_of(trail_.begin(), trail_.end(), [&](const TrailPoint& p) {
      return is_near(at.x - p.x, at.y - p.y) && along(p.yaw) < params_.trail_against;
    });
  }

  const LocalWalls& walls_;
  const Buffer<TrailPoint>& trail_;
  const LineLimits& limits_;
  const CenterlineParams& params_;
  double width_;
  double half_car_;
  std::size_t loop_points_;  // points per `loop_length`
  double meeting_distance_;  // [m] maximum distance at which lines meet
  Box trail_box_;
};

// Whether the straight segment from a to b crosses a wall: the track does not continue behind it.
bool meets_wall(const LocalWalls& walls, Point2 a, Point2 b, const CenterlineParams& params) noexcept {
  const double length = norm(b.x - a.x, b.y - a.y);
  const int pieces = static_cast<int>(2.0 * length / params.spacing);
  for (int k = 1; k <= pieces; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(pieces);
    const double x = a.x + t * (b.x - a.x);
    const double y = a.y + t * (b.y - a.y);
    const double nearest =
        std::min(nearest_sample(walls.left, x, y).distance, nearest_sample(walls.right, x, y).distance);
    if (nearest < params.seed_wall * params.spacing) return true;
  }
  return false;
}

// Removes the points after the last one that is supported by a wall.
void end_at_last_wall(Buffer<CenterlinePoint>& points) noexcept {
  while (!points.empty() && points.back().support == WallSupport::none) points.shrink(points.size() - 1);
}

double line_length(const Buffer<CenterlinePoint>& points, std::size_t first) noexcept {
  double length = 0.0;
  for (std::size_t i = first + 1; i < points.size(); ++i)
    length += norm(points[i].x - points[i - 1].x, points[i].y - points[i - 1].y);
  return length;
}

// Traces the line from `seed`, which lies `ahead` [m] of the front axle.
void trace_both_ways(const Tracer& tracer, const LinePoint& seed, double ahead, const CenterlineParams& params,
                     Centerline& line) noexcept {
  tracer.trace(seed, -1.0, params.start_behind + ahead, line.points);
  end_at_last_wall(line.points);
  std::reverse(line.points.begin(), line.points.end());
  if (!line.points.empty()) line.points.shrink(line.points.size() - 1);
  line.nearest = line.points.size();
  line.end = tracer.trace(seed, 1.0, params.horizon, line.points);
  end_at_last_wall(line.points);
  line.ahead = line_length(line.points, std::min(line.nearest, line.points.size())) + ahead;
}

}  // namespace

void trace_centerline(const LineScene& scene, const LineLimits& limits, Centerline& line) noexcept {
  line.points.clear();
  line.nearest = 0;
  line.ahead = 0.0;
  line.end = LineEnd::none;
  const CenterlineParams& params = limits.line;
  const Point2 front_axle{limits.car.wheelbase, 0.0};
  const Tracer tracer(scene, limits);

  // The walls beside the car may be occluded: start as close to the front axle as possible.
  const double step = params.seed_step;
  const int tries = static_cast<int>(params.seed_reach / step) + 2;
  for (int i = 0; i < tries; ++i) {
    const double ahead = i + 1 < tries ? step * i : -step;
    LinePoint seed{{front_axle.x + ahead, 0.0}, {}};
    if (!tracer.project(seed) || seed.view.slope() < flat) continue;
    if (meets_wall(scene.walls, front_axle, seed.at, params)) continue;
    trace_both_ways(tracer, seed, std::max(0.0, ahead), params, line);
    return;
  }
}

}  // namespace firstlap
