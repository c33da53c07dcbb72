#include "firstlap/sim/car_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "firstlap/sim/contact.hpp"

namespace firstlap::sim {
namespace {

// Maximum number of turns by which a beam angle including the mounting may exceed (-pi, pi].
constexpr int max_turns = 3;
constexpr float inf = std::numeric_limits<float>::infinity();

Point2 to_laser(const Pose2& laser, double x, double y) noexcept {
  const double c = std::cos(laser.yaw), s = std::sin(laser.yaw), dx = x - laser.x, dy = y - laser.y;
  return {c * dx + s * dy, c * dy - s * dx};
}

// The beams between the directions `low` and `high` [rad] in the LiDAR's frame.
BeamRange beams_between(const LidarParams& lidar, double low, double high) noexcept {
  const double per_radian = 1.0 / lidar.angle_increment();
  const double one = (low - lidar.angle_min()) * per_radian;
  const double other = (high - lidar.angle_min()) * per_radian;
  return {static_cast<int>(std::ceil(std::min(one, other))), static_cast<int>(std::floor(std::max(one, other))) + 1};
}

// Shortens the ranges of `beams` to where they meet `edge`, which is in the LiDAR's frame.
void shorten(const LidarParams& lidar, const WallSegment& edge, BeamRange beams, std::span<float> out) noexcept {
  const auto range_min = static_cast<float>(lidar.range_min), range_max = static_cast<float>(lidar.range_max);
  for (int i = beams.first; i < beams.last; ++i) {
    const double angle = lidar.angle_min() + i * lidar.angle_increment();
    const auto range = static_cast<float>(lidar.range_scale * range_along({std::cos(angle), std::sin(angle)}, edge));
    float& seen = out[static_cast<std::size_t>(i)];
    if (range < seen && range <= range_max) seen = range < range_min ? -inf : range;
  }
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

void draw_body(const LidarParams& lidar, const Pose2& laser, std::span<const WallSegment, 4> edges, BeamRange beams,
               std::span<float> out) noexcept {
  beams.last = std::min(beams.last, static_cast<int>(out.size()));
  for (const WallSegment& edge : edges) {
    const Point2 a = to_laser(laser, edge.x1, edge.y1), b = to_laser(laser, edge.x2, edge.y2);
    const double from = std::atan2(a.y, a.x);
    const double turn = std::remainder(std::atan2(b.y, b.x) - from, 2.0 * std::numbers::pi);
    const double low = std::min(from, from + turn), high = std::max(from, from + turn);
    for (int turn_of = -max_turns; turn_of <= max_turns; ++turn_of) {
      const double lap = 2.0 * std::numbers::pi * turn_of;
      const BeamRange met = beams_between(lidar, low + lap, high + lap);
      shorten(lidar, {a.x, a.y, b.x, b.y}, {std::max(met.first, beams.first), std::min(met.last, beams.last)}, out);
    }
  }
}

bool bodies_touch(const CarGeometry& car, const Pose2& a, const Pose2& b) noexcept {
  if (std::hypot(a.x - b.x, a.y - b.y) > 2.0 * reach(car)) return false;
  const auto edges = body_edges(car, b);
  return std::any_of(edges.begin(), edges.end(), [&](const WallSegment& edge) { return touch(car, a, edge); });
}

}  // namespace firstlap::sim
