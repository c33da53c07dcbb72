// Step 5: the centerline as a smooth path with curvature: Laplacian smoothing, a start at the car, Opheim
// simplification, a cubic C2 spline.
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

// Smooths the centerline; no point comes closer to a wall than half the car's width plus smoothing_margin, unless the
// centerline itself is as close.
void smooth_between_walls(const Buffer<CenterlinePoint>& line, const CarGeometry& car, const TrajectoryParams& params,
                          Buffer<Point2>& points) noexcept;

// Distance [m] from a centerline point to the nearest wall: half the width, but if that is estimated, at most the
// distance to the nearest sample.
double clearance_at(const CenterlinePoint& point) noexcept;

// Shifts the start of the line so that it leaves base_link along the car's heading, with a heading error of at most
// `angle` [rad], and rejoins the line after `distance` [m]. The lateral offset is a quintic.
void join_car(double distance, double angle, Buffer<Point2>& points) noexcept;

// Shifts the start of the line to where the previous path passes base_link. The residual decays with exp(-s / `reach`),
// `reach` in [m]: the one shape that stays the same curve when it is carried over at every scan, whatever the scan
// rate. Without a previous path, the path starts at the car. `previous` in the current base_link frame.
void join_previous(const Buffer<TrajectoryPoint>& previous, double reach, Buffer<Point2>& points) noexcept;

// Opheim (1982) as in psimpl: from each kept point, drops the points within `tol_max` of it and within `tol_min` of the
// ray from it. Copies the points if a tolerance is zero or there are fewer than 3.
void simplify_opheim(const Buffer<Point2>& points, double tol_min, double tol_max, Buffer<Point2>& knots) noexcept;

// Samples the spline through `knots` every `sample` [m]. The curvature is held constant over the last `end_hold` [m].
void sample_path(const Buffer<Point2>& knots, double sample, double end_hold, Spline& spline,
                 Buffer<TrajectoryPoint>& path) noexcept;

// Index of the path point nearest to (x, y). The path must not be empty.
std::size_t nearest_on_path(const Buffer<TrajectoryPoint>& path, double x, double y) noexcept;

}  // namespace firstlap
