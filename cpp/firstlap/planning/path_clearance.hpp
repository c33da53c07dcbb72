// What stands on or beside the path, wall or not: how near the car comes to it, and where it would have to stop.
#pragma once

#include <cstddef>
#include <limits>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

struct PathClearance {
  double distance = std::numeric_limits<double>::infinity();    // [m] smallest, the car's side to anything
  double blocked_at = std::numeric_limits<double>::infinity();  // [m] of the path: there it is too small
};

// Along `path` (in base_link) from its point `nearest` on, up to where it is blocked, among all that was seen.
PathClearance clearance_along(const Buffer<TrajectoryPoint>& path, std::size_t nearest, const LocalWalls& walls,
                              const CarGeometry& car, const VelocityProfileParams& params) noexcept;

}  // namespace firstlap
