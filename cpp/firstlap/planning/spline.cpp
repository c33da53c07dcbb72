#include "firstlap/planning/spline.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {

Spline::Spline(std::size_t capacity)
    : u_(capacity), x_(capacity), y_(capacity), xx_(capacity), yy_(capacity), upper_(capacity), rhs_(capacity) {}

bool Spline::fit(const Buffer<Point2>& points) noexcept {
  u_.clear();
  x_.clear();
  y_.clear();
  for (const Point2& p : points) {
    const double step = u_.empty() ? 0.0 : norm(p.x - x_.back(), p.y - y_.back());
    if (!u_.empty() && step < 1e-6) continue;
    u_.push(u_.empty() ? 0.0 : u_.back() + step);
    x_.push(p.x);
    y_.push(p.y);
  }
  if (u_.size() < 2) return false;
  solve(x_, xx_);
  solve(y_, yy_);
  return true;
}

// Thomas algorithm for the second derivatives of a natural spline.
void Spline::solve(const Buffer<double>& values, Buffer<double>& second) noexcept {
  const std::size_t n = u_.size();
  upper_.clear();
  rhs_.clear();
  second.clear();
  upper_.push(0.0);
  rhs_.push(0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = u_[i] - u_[i - 1];
    const double h1 = u_[i + 1] - u_[i];
    const double slope = (values[i + 1] - values[i]) / h1 - (values[i] - values[i - 1]) / h0;
    const double pivot = 2.0 * (h0 + h1) - h0 * upper_[i - 1];
    upper_.push(h1 / pivot);
    rhs_.push((6.0 * slope - h0 * rhs_[i - 1]) / pivot);
  }
  for (std::size_t i = 0; i < n; ++i) second.push(0.0);
  for (std::size_t i = n - 1; i-- > 1;) second[i] = rhs_[i] - upper_[i] * second[i + 1];
}

SplineSample Spline::at(double u, std::size_t& hint) const noexcept {
  u = std::clamp(u, 0.0, length());
  std::size_t i = std::min(hint, u_.size() - 2);
  while (i > 0 && u < u_[i]) --i;
  while (i + 2 < u_.size() && u > u_[i + 1]) ++i;
  hint = i;
  const double h = u_[i + 1] - u_[i];
  const double a = (u_[i + 1] - u) / h;
  const double b = 1.0 - a;
  const auto value = [&](const Buffer<double>& f, const Buffer<double>& f2) {
    return a * f[i] + b * f[i + 1] + ((a * a * a - a) * f2[i] + (b * b * b - b) * f2[i + 1]) * h * h / 6.0;
  };
  const auto first = [&](const Buffer<double>& f, const Buffer<double>& f2) {
    return (f[i + 1] - f[i]) / h + ((3.0 * b * b - 1.0) * f2[i + 1] - (3.0 * a * a - 1.0) * f2[i]) * h / 6.0;
  };
  const double dx = first(x_, xx_);
  const double dy = first(y_, yy_);
  const double ddx = a * xx_[i] + b * xx_[i + 1];
  const double ddy = a * yy_[i] + b * yy_[i + 1];
  const double speed = std::max(norm(dx, dy), 1e-9);
  return {value(x_, xx_), value(y_, yy_), std::atan2(dy, dx), (dx * ddy - dy * ddx) / (speed * speed * speed)};
}

}  // namespace firstlap
