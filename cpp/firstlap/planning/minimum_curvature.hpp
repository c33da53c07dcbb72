// Step 5, beyond the paper: of all paths between the walls the one that bends least, from where the car is and along
// the arc that it drives. It swings out before a bend, cuts it and swings out again (docs/adr/).
#pragma once

#include <cstddef>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/planning/centerline.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

inline constexpr std::size_t max_control_points = 64;

// One control point of the path, which may move along a normal of the smoothed centerline.
struct ControlPoint {
  Point2 on_line{};     // [m] base_link
  Point2 normal{};      // unit, to the left
  double low = 0.0;     // [m] the offsets that are allowed, left positive
  double high = 0.0;    // [m]
  double offset = 0.0;  // [m]
  Point2 at{};          // [m] base_link: on_line + offset normal
  double step = 0.0;    // [m] from the control point before
};

// What the path depends on besides the line.
struct PathConditions {
  double curvature = 0.0;  // [1/m] of the arc that the car drives
  double clearance = 0.0;  // [m] of base_link from the walls
  double spacing = 0.0;    // [m] of the line's points
};

// `points`: `line` smoothed, point by point; replaced by the path's control points, the first behind the car. False,
// and `points` as they were, without passes and where the line is too short.
bool minimum_curvature_path(const Buffer<CenterlinePoint>& line, const PathConditions& conditions,
                            const MinimumCurvatureParams& params, Buffer<ControlPoint>& control_points,
                            Buffer<Point2>& points) noexcept;

}  // namespace firstlap
