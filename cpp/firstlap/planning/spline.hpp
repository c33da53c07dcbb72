// Natural cubic spline (C2) through points in the plane, parameterized by chord length. Never extrapolates.
#pragma once

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap {

struct SplineSample {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;        // [rad]
  double curvature = 0.0;  // [1/m]
};

class Spline {
 public:
  explicit Spline(std::size_t capacity);

  // Skips points closer than 1e-6 m to their predecessor. Returns false for fewer than 2 points.
  bool fit(const Buffer<Point2>& points) noexcept;

  [[nodiscard]] double length() const noexcept { return u_.empty() ? 0.0 : u_.back(); }  // [m] sum of the chords
  // The point at chord length `u` [m], clamped to [0, length()]. `hint` is the interval to search first and is updated.
  [[nodiscard]] SplineSample at(double u, std::size_t& hint) const noexcept;

 private:
  void solve(const Buffer<double>& values, Buffer<double>& second) noexcept;

  Buffer<double> u_, x_, y_, xx_, yy_;  // knots, values, second derivatives
  Buffer<double> upper_, rhs_;          // of the tridiagonal system
};

}  // namespace firstlap
