// Step 5, beyond the paper: of all paths between the walls the one that bends least, from where the car is and along
// the arc that it drives. It swings out before a bend, cuts it and swings out again (docs/adr/).
#pragma once

#include <cstddef>

#include "firstlap/buffer.hpp"
#include "firstlap/centerline.hpp"
#include "firstlap/params.hpp"
#include "firstlap/types.hpp"

namespace firstlap {

inline constexpr std::size_t max_keys = 64;

// One key of the path, which may move along a normal of the smoothed centerline.
struct PathKey {
  Point2 on_line{};     // [m] base_link
  Point2 normal{};      // unit, to the left
  double low = 0.0;     // [m] the offsets that are allowed, left positive
  double high = 0.0;    // [m]
  double offset = 0.0;  // [m]
  Point2 at{};          // [m] base_link: on_line + offset normal
  double step = 0.0;    // [m] from the key before
};

// `points`: `line` smoothed, point by point; replaced by the path's keys, the first behind the car. `curvature` [1/m]
// of the arc that the car drives. False, and `points` as they were, without passes and where the line is too short.
bool bend_least(const Buffer<CenterlinePoint>& line, double curvature, const Params& params, Buffer<PathKey>& keys,
                Buffer<Point2>& points) noexcept;

}  // namespace firstlap
