// Plane geometry shared by several stages.
#pragma once

#include <cmath>
#include <numbers>

#include "firstlap/common/types.hpp"

namespace firstlap {

// Length of a vector. May overflow, unlike std::hypot, but no wall is 1e150 m away, and it is ten times faster.
inline double norm(double x, double y) noexcept { return std::sqrt(x * x + y * y); }

inline double distance(const Point2& a, const Point2& b) noexcept { return norm(a.x - b.x, a.y - b.y); }

// The angle [rad] wrapped to [-pi, pi].
inline double wrap_angle(double angle) noexcept { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace firstlap
