#include "firstlap/sim/obstacle.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firstlap/sim/contact.hpp"

namespace firstlap::sim {

Walls box_walls(const Pose2& middle, double length, double width) {
  const double c = std::cos(middle.yaw), s = std::sin(middle.yaw), l = 0.5 * length, w = 0.5 * width;
  const auto corner = [&](double along, double across) {
    return Point2{middle.x + along * c - across * s, middle.y + along * s + across * c};
  };
  const std::array<Point2, 5> p{corner(l, -w), corner(l, w), corner(-l, w), corner(-l, -w), corner(l, -w)};
  std::vector<WallSegment> sides;
  for (std::size_t i = 0; i + 1 < p.size(); ++i) sides.push_back({p[i].x, p[i].y, p[i + 1].x, p[i + 1].y});
  return Walls(std::move(sides));
}

Obstacle::Obstacle(const Pose2& middle, double length, double width, const LidarParams& lidar)
    : middle_(middle),
      half_length_(0.5 * length),
      half_width_(0.5 * width),
      walls_(box_walls(middle, length, width)),
      lidar_(lidar, walls_),
      ranges_(static_cast<std::size_t>(lidar.beams)) {}

void Obstacle::add_to_scan(const Pose2& laser, int first, int last, std::span<float> ranges) {
  if (ranges.size() != ranges_.size()) {
    lidar_.set_beams(static_cast<int>(ranges.size()));
    ranges_.resize(ranges.size());
  }
  lidar_.scan_sector(laser, first, last, ranges_);
  const auto end = std::min(static_cast<std::size_t>(std::max(last, 0)), ranges.size());
  for (auto i = static_cast<std::size_t>(std::max(first, 0)); i < end; ++i) ranges[i] = std::min(ranges[i], ranges_[i]);
}

// Testing the sides alone would miss a car that is entirely inside a large box when it appears.
std::optional<Point2> Obstacle::touch(const CarGeometry& car, const Pose2& base_link) const noexcept {
  if (const auto found = sim::touch(car, base_link, walls_)) return found;
  const double dx = base_link.x - middle_.x, dy = base_link.y - middle_.y;
  const double c = std::cos(middle_.yaw), s = std::sin(middle_.yaw);
  const bool inside = std::abs(c * dx + s * dy) <= half_length_ && std::abs(c * dy - s * dx) <= half_width_;
  return inside ? std::optional<Point2>({base_link.x, base_link.y}) : std::nullopt;
}

double Obstacle::clearance(const CarGeometry& car, const Pose2& base_link) const noexcept {
  return touch(car, base_link) ? 0.0 : sim::clearance(car, base_link, walls_);
}

}  // namespace firstlap::sim
