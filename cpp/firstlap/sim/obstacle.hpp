// A sudden obstacle: a box that appears on the track when the car comes near. From then on it is visible, solid and
// stays.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// The four sides of a box [m], `length` along the heading of its center, `width` across, counterclockwise.
Walls box_walls(const Pose2& middle, double length, double width);

class Obstacle {
 public:
  // Throws std::invalid_argument if the center is not finite or a LiDAR parameter is out of range.
  Obstacle(const Pose2& middle, double length, double width, const LidarParams& lidar);

  Obstacle(const Obstacle&) = delete;
  Obstacle& operator=(const Obstacle&) = delete;

  // Shortens the ranges of beams [first, last) to the box where it is nearer, exactly as Lidar::scan_sector does.
  void add_to_scan(const Pose2& laser, int first, int last, std::span<float> ranges);

  const Pose2& middle() const noexcept { return middle_; }
  const Walls& walls() const noexcept { return walls_; }

  // A contact point if box and car overlap, even if one is inside the other.
  std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link) const noexcept;
  double clearance(const CarGeometry& car, const Pose2& base_link) const noexcept;  // [m], 0 in contact

 private:
  Pose2 middle_;
  double half_length_, half_width_;
  Walls walls_;
  Lidar lidar_;
  std::vector<float> ranges_;
};

}  // namespace firstlap::sim
