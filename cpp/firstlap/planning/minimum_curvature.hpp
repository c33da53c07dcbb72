// Step 5, beyond the paper: among all paths between the walls, the one with minimum squared curvature that continues
// the arc of the car. It swings out before a corner, cuts the apex and swings out again (docs/adr/).
#pragma once

#include <cstddef>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/planning/centerline.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

inline constexpr std::size_t max_control_points = 64;

// A control point of the path. It moves along a normal of the smoothed centerline.
struct ControlPoint {
  Point2 on_line{};     // [m] base_link
  Point2 normal{};      // unit vector, left positive
  double low = 0.0;     // [m] lower limit of the offset
  double high = 0.0;    // [m] upper limit of the offset
  double offset = 0.0;  // [m] left positive
  Point2 at{};          // [m] base_link: on_line + offset normal
  double step = 0.0;    // [m] distance from the previous control point
};

// Boundary conditions of the path besides the centerline.
struct PathConditions {
  double curvature = 0.0;  // [1/m] curvature of the arc that the car is driving
  double clearance = 0.0;  // [m] minimum distance of base_link from the walls
};

// `points`: the smoothed centerline, one point for each of `line`; replaced by the control points of the path, the
// first of them behind the car. Returns false and leaves `points` unchanged if bend_passes is 0 or the line is too
// short.
bool minimum_curvature_path(const Buffer<CenterlinePoint>& line, const PathConditions& conditions,
                            const MinimumCurvatureParams& params, Buffer<ControlPoint>& control_points,
                            Buffer<Point2>& points) noexcept;

}  // namespace firstlap
