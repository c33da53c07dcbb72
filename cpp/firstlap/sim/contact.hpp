// The car's rectangle against walls, exactly. Poses are of base_link in the map frame.
#pragma once

#include <optional>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// A point [m, map frame] common to the rectangle and the segment, the middle of the common part; none if apart.
std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const WallSegment& segment) noexcept;

// Distance [m] between the rectangle and the segment; 0 when they touch.
double clearance(const CarGeometry& car, const Pose2& base_link, const WallSegment& segment) noexcept;

// The same against all solid segments; +inf without one.
std::optional<Point2> touch(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept;
double clearance(const CarGeometry& car, const Pose2& base_link, const Walls& walls) noexcept;

// Farthest point of the rectangle from base_link [m].
double reach(const CarGeometry& car) noexcept;

}  // namespace firstlap::sim
