// Cars as obstacles: rectangles that a LiDAR sees and that other cars touch. Map frame, SI units.
#pragma once

#include <array>
#include <span>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// The four edges of a car's rectangle with base_link at `pose`, counter-clockwise.
std::array<WallSegment, 4> body_edges(const CarGeometry& car, const Pose2& pose) noexcept;

// Brings the ranges of beams [first, last) down to where they meet one of the edges. `out` holds all beams, as
// Lidar::scan left them.
void draw_body(const LidarParams& lidar, const Pose2& laser, std::span<const WallSegment, 4> edges, int first, int last,
               std::span<float> out) noexcept;

// Whether the rectangles of two cars of this geometry touch.
bool bodies_touch(const CarGeometry& car, const Pose2& a, const Pose2& b) noexcept;

}  // namespace firstlap::sim
