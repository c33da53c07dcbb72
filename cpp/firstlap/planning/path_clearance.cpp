#include "firstlap/planning/path_clearance.hpp"

#include <algorithm>

namespace firstlap {
namespace {

constexpr std::size_t stride = 2;  // every other path point: points in between are closer to one than the spacing

// Distance [m] of (x, y) to the nearest wall sample.
double wall_distance(const LocalWalls& walls, double x, double y) noexcept {
  const double left = nearest_sample(walls.left, x, y).distance;
  const double right = nearest_sample(walls.right, x, y).distance;
  return std::min(left, right);
}

}  // namespace

PathClearance clearance_along(const Buffer<TrajectoryPoint>& path, std::size_t nearest, const LocalWalls& walls,
                              const CarGeometry& car, const VelocityProfileParams& params) noexcept {
  const double nose_at = path[nearest].s + nose(car);
  PathClearance found;
  for (std::size_t i = nearest; i < path.size() && path[i].s < found.blocked_at; i += stride) {
    const TrajectoryPoint& point = path[i];
    const double distance = wall_distance(walls, point.x, point.y) - 0.5 * car.width;
    found.distance = std::min(found.distance, distance);
    if (distance < params.block_clearance && point.s > nose_at) found.blocked_at = point.s;
  }
  return found;
}

}  // namespace firstlap
