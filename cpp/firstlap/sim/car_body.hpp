// Cars as obstacles: rectangles visible to LiDARs and solid to other cars. Map frame, SI units.
#pragma once

#include <array>
#include <span>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// The four edges of the car's rectangle with base_link at `pose`, counterclockwise.
std::array<WallSegment, 4> body_edges(const CarGeometry& car, const Pose2& pose) noexcept;

// Beams [first, last) in scan order.
struct BeamRange {
  int first = 0;
  int last = 0;
};

// Shortens the ranges of `beams` to where they meet one of the edges. `out` holds all beams, from Lidar::scan.
void draw_body(const LidarParams& lidar, const Pose2& laser, std::span<const WallSegment, 4> edges, BeamRange beams,
               std::span<float> out) noexcept;

// Whether the rectangles of two cars of this geometry touch.
bool bodies_touch(const CarGeometry& car, const Pose2& a, const Pose2& b) noexcept;

}  // namespace firstlap::sim
