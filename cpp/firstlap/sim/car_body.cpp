#include "firstlap/sim/car_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "firstlap/sim/contact.hpp"

namespace firstlap::sim {
namespace {

constexpr int max_turns =
    3;  // maximum number of turns by which a beam angle including the mounting may exceed (-pi, pi]
constexpr float inf = std::numeric_limits<float>::infinity();

// Range along the unit vector (c, s) to the segment from (x1, y1) to (x2, y2), in the LiDAR's frame; inf without a hit.
double range_to(double c, double s, double x1, double y1, double x2, double y2) noexcept {
  const double dx = x2 - x1, dy = y2 - y1, across = c * dy - s * dx;
  if (across == 0.0) return inf;
  const double range = (x1 * dy - y1 * dx) / across, share = (x1 * s - y1 * c) / across;
  return range >= 0.0 && share >= 0.0 && share <= 1.0 ? range : inf;
}

Point2 to_laser(const Pose2& laser, double x, double y) noexcept {
  const double c = std::cos(laser.yaw), s = std::sin(laser.yaw), dx = x - laser.x, dy = y - laser.y;
  return {c * dx + s * dy, c * dy - s * dx};
}

}  // namespace

std::array<WallSegment, 4> body_edges(const CarGeometry& car, const Pose2& pose) noexcept {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto [front, rear, side] = Footprint(car);
  const auto corner = [&](double x, double y) { return Point2{pose.x + c * x - s * y, pose.y + s * x + c * y}; };
  const std::array<Point2, 4> corners{corner(rear, -side), corner(front, -side), corner(front, side),
                                      corner(rear, side)};
  std::array<WallSegment, 4> edges{};
  for (std::size_t i = 0; i < 4; ++i) {
    const Point2 a = corners[i], b = corners[(i + 1) % 4];
    edges[i] = {a.x, a.y, b.x, b.y};
  }
  return edges;
}

void draw_body(const LidarParams& lidar, const Pose2& laser, std::span<const WallSegment, 4> edges, int first, int last,
               std::span<float> out) noexcept {
  const auto range_min = static_cast<float>(lidar.range_min), range_max = static_cast<float>(lidar.range_max);
  last = std::min(last, static_cast<int>(out.size()));
  for (const WallSegment& edge : edges) {
    const Point2 a = to_laser(laser, edge.x1, edge.y1), b = to_laser(laser, edge.x2, edge.y2);
    const double from = std::atan2(a.y, a.x);
    const double turn = std::remainder(std::atan2(b.y, b.x) - from, 2.0 * std::numbers::pi);
    const double low = std::min(from, from + turn), high = std::max(from, from + turn);
    for (int turn_of = -max_turns; turn_of <= max_turns; ++turn_of) {
      const double lap = 2.0 * std::numbers::pi * turn_of, per_radian = 1.0 / lidar.angle_increment();
      const double one = (low + lap - lidar.angle_min()) * per_radian;
      const double other = (high + lap - lidar.angle_min()) * per_radian;
      const int begin = static_cast<int>(std::ceil(std::min(one, other)));
      const int end = static_cast<int>(std::floor(std::max(one, other))) + 1;
      for (int i = std::max(begin, first); i < std::min(end, last); ++i) {
        const double angle = lidar.angle_min() + i * lidar.angle_increment();
        const auto range =
            static_cast<float>(lidar.range_scale * range_to(std::cos(angle), std::sin(angle), a.x, a.y, b.x, b.y));
        float& seen = out[static_cast<std::size_t>(i)];
        if (range < seen && range <= range_max) seen = range < range_min ? -inf : range;
      }
    }
  }
}

bool bodies_touch(const CarGeometry& car, const Pose2& a, const Pose2& b) noexcept {
  if (std::hypot(a.x - b.x, a.y - b.y) > 2.0 * reach(car)) return false;
  const auto edges = body_edges(car, b);
  return std::any_of(edges.begin(), edges.end(), [&](const WallSegment& edge) { return touch(car, a, edge); });
}

}  // namespace firstlap::sim
