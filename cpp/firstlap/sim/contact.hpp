// Exact contact and clearance of the car's rectangle. Poses are of base_link in the map frame.
#pragma once

#include <optional>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// A point [m, map frame] common to rectangle and segment, the middle of the common part; none without contact.
std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const WallSegment& segment) noexcept;

// Distance [m] between rectangle and segment; 0 in contact.
double clearance(const CarGeometry& car, const Pose2& base_link, const WallSegment& segment) noexcept;

// The same for all solid segments; +inf if there are none.
std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept;
double clearance(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept;

// Distance [m] from base_link to the farthest point of the rectangle.
double reach(const CarGeometry& car) noexcept;

}  // namespace firstlap::sim
