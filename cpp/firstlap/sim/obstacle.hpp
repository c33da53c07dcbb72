// A box that was not there a moment ago: it appears on the track when the car comes near, is seen by the LiDAR
// and solid from then on, and stays.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// The four sides of a box [m], `length` along the heading of its middle, `width` across, counter-clockwise.
Walls box_walls(const Pose2& middle, double length, double width);

class Obstacle {
 public:
  // Throws std::invalid_argument where the middle is not finite or the lidar's parameters are wrong.
  Obstacle(const Pose2& middle, double length, double width, const LidarParams& lidar);

  Obstacle(const Obstacle&) = delete;
  Obstacle& operator=(const Obstacle&) = delete;

  // Beams [first, last) of `ranges` where the box is nearer than what they hold: exact, as Lidar::scan_sector.
  void add_to_scan(const Pose2& laser, int first, int last, std::span<float> ranges);

  const Pose2& middle() const noexcept { return middle_; }
  const Walls& walls() const noexcept { return walls_; }

  // Whether any of the box lies in the car's rectangle or the car in the box.
  std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link) const noexcept;
  double clearance(const CarGeometry& car, const Pose2& base_link) const noexcept;  // [m], 0 when they touch

 private:
  Pose2 middle_;
  double half_length_, half_width_;
  Walls walls_;
  Lidar lidar_;
  std::vector<float> ranges_;
};

}  // namespace firstlap::sim
