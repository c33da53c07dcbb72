#include "firstlap/sim/contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace firstlap::sim {
namespace {

// An axis-aligned rectangle in base_link [m].
struct Box {
  double x0, x1, y0, y1;
};

Box box_of(const CarGeometry& car) noexcept {
  const Footprint body(car);
  return {body.rear, body.front, -body.side, body.side};
}

Point2 to_base_link(const Pose2& base_link, double x, double y) noexcept {
  const double c = std::cos(base_link.yaw), s = std::sin(base_link.yaw);
  const double dx = x - base_link.x, dy = y - base_link.y;
  return {c * dx + s * dy, c * dy - s * dx};
}

WallSegment to_base_link(const Pose2& base_link, const WallSegment& w) noexcept {
  const Point2 a = to_base_link(base_link, w.x1, w.y1), b = to_base_link(base_link, w.x2, w.y2);
  return {a.x, a.y, b.x, b.y};
}

// Part of a segment, as fractions of it.
struct Part {
  double from = 0.0, to = 1.0;
};

// Narrows `part` to where start + t step lies in [low, high]; false if nothing is left.
bool clip(double start, double step, double low, double high, Part& part) noexcept {
  if (step == 0.0) return start >= low && start <= high;
  double enter = (low - start) / step, leave = (high - start) / step;
  if (enter > leave) std::swap(enter, leave);
  part = {std::max(part.from, enter), std::min(part.to, leave)};
  return part.from <= part.to;
}

// Middle of the segment's part inside the box, as a fraction of the segment (Liang and Barsky, 1984).
std::optional<double> middle_inside(const Box& box, const WallSegment& w) noexcept {
  Part part;
  if (!clip(w.x1, w.x2 - w.x1, box.x0, box.x1, part)) return std::nullopt;
  if (!clip(w.y1, w.y2 - w.y1, box.y0, box.y1, part)) return std::nullopt;
  return 0.5 * (part.from + part.to);
}

double distance_to_box(const Box& box, double x, double y) noexcept {
  const double dx = std::max({box.x0 - x, 0.0, x - box.x1}), dy = std::max({box.y0 - y, 0.0, y - box.y1});
  return std::sqrt(dx * dx + dy * dy);
}

// Both are convex: without overlap, the nearest points include a corner or an end point.
double distance(const Box& box, const WallSegment& w) noexcept {
  if (middle_inside(box, w)) return 0.0;
  double best = std::min(distance_to_box(box, w.x1, w.y1), distance_to_box(box, w.x2, w.y2));
  for (const Point2 corner : {Point2{box.x0, box.y0}, {box.x1, box.y0}, {box.x1, box.y1}, {box.x0, box.y1}}) {
    best = std::min(best, distance(corner, w));
  }
  return best;
}

}  // namespace

std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const WallSegment& w) noexcept {
  const auto t = middle_inside(box_of(car), to_base_link(base_link, w));
  if (!t) return std::nullopt;
  return Point2{w.x1 + *t * (w.x2 - w.x1), w.y1 + *t * (w.y2 - w.y1)};
}

double clearance(const CarGeometry& car, const Pose2& base_link, const WallSegment& w) noexcept {
  return distance(box_of(car), to_base_link(base_link, w));
}

std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept {
  std::optional<Point2> found;
  walls.for_each_near({base_link.x, base_link.y}, reach(car), [&](std::size_t i) {
    if (!found && walls.segments()[i].solid) found = touch(car, base_link, walls.segments()[i]);
  });
  return found;
}

double clearance(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept {
  return walls.nearest_solid({base_link.x, base_link.y}, reach(car),
                             [&](std::size_t i) { return clearance(car, base_link, walls.segments()[i]); });
}

double reach(const CarGeometry& car) noexcept {
  const Footprint body(car);
  return std::hypot(std::max(-body.rear, body.front), body.side);
}

}  // namespace firstlap::sim
