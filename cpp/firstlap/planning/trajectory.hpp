// Step 5: the centerline as a smooth path with curvature: Laplacian smoothing, a start at the car,
// Opheim simplification, a cubic C2 spline.
#pragma once

#include <cstddef>
#include <span>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/planning/centerline.hpp"
#include "firstlap/planning/params.hpp"
#include "firstlap/planning/spline.hpp"

namespace firstlap {

inline constexpr std::size_t max_path_points = 512;

// p_i += lambda (mean of the neighbors - p_i), ends fixed.
void smooth(double lambda, int iterations, Buffer<Point2>& points) noexcept;

// The line smoothed, but no point of it brought nearer to a wall than the car's half width and a margin,
// unless the line itself is as near.
void smooth_between_walls(const Buffer<CenterlinePoint>& line, const CarGeometry& car, const TrajectoryParams& params,
                          Buffer<Point2>& points) noexcept;

// Distance from a point of the line to the nearest thing beside it: half the width, and where that is estimated
// no more than to what was seen.
double clearance_at(const CenterlinePoint& point) noexcept;

// Bends the line's beginning so that it leaves base_link along the car's heading and is back on the line
// `distance` [m] later, by a quintic in the lateral offset.
void join_car(double distance, double angle, Buffer<Point2>& points) noexcept;

// Opheim (1982) with psimpl's semantics: from each key, points within `tol_max` of it and within
// `tol_min` of the ray that leaves it are dropped. A zero tolerance or fewer than 3 points: a copy.
void simplify_opheim(const Buffer<Point2>& points, double tol_min, double tol_max, Buffer<Point2>& keys) noexcept;

// Samples the spline through `keys` every `sample` m; curvature is held over the last `end_hold` m.
void sample_path(const Buffer<Point2>& keys, double sample, double end_hold, Spline& spline,
                 Buffer<TrajectoryPoint>& path) noexcept;

// Index of the path point nearest to (x, y); path not empty.
std::size_t nearest_on_path(const Buffer<TrajectoryPoint>& path, double x, double y) noexcept;

}  // namespace firstlap
