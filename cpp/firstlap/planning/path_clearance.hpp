// Clearance along the path to everything visible, walls or obstacles, and where the path is blocked.
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
  double distance = std::numeric_limits<double>::infinity();    // [m] smallest distance of the car's side
  double blocked_at = std::numeric_limits<double>::infinity();  // [m] arc length where the clearance is too small
};

// Clearance along `path` (base_link), from its point `nearest` up to the blocked point.
PathClearance clearance_along(const Buffer<TrajectoryPoint>& path, std::size_t nearest, const LocalWalls& walls,
                              const CarGeometry& car, const VelocityProfileParams& params) noexcept;

}  // namespace firstlap
