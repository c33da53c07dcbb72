#include "firstlap/walls_seen.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace firstlap {
namespace {

void move_side(const Pose2& motion, double dt, WallSide& side) noexcept {
  const double c = std::cos(motion.yaw);
  const double s = std::sin(motion.yaw);
  for (std::size_t i = 0; i < side.size(); ++i) {
    const double dx = static_cast<double>(side.x[i]) - motion.x;
    const double dy = static_cast<double>(side.y[i]) - motion.y;
    side.x[i] = static_cast<float>(c * dx + s * dy);
    side.y[i] = static_cast<float>(-s * dx + c * dy);
    const Point2 out = side.outward[i];
    side.outward[i] = {c * out.x + s * out.y, -s * out.x + c * out.y};
    side.age[i] += static_cast<float>(dt);
  }
}

}  // namespace

void WallSide::clear() noexcept {
  x.clear();
  y.clear();
  outward.clear();
  age.clear();
  seen = 0;
}

void WallSide::push(double px, double py, Point2 out, float seen_before) noexcept {
  x.push(static_cast<float>(px));
  y.push(static_cast<float>(py));
  outward.push(out);
  age.push(seen_before);
}

// Four samples at a time, in the vectors that gcc and clang offer on every processor: as a plain loop
// this search would take half of a step.
Nearest nearest_sample(const WallSide& side, double px, double py) noexcept {
  constexpr std::size_t lanes = 4;
  using Floats = float __attribute__((vector_size(16)));
  using Ints = std::int32_t __attribute__((vector_size(16)));
  const std::size_t n = side.size();
  const float* xs = side.x.data();
  const float* ys = side.y.data();
  const auto fx = static_cast<float>(px);
  const auto fy = static_cast<float>(py);
  constexpr float far = std::numeric_limits<float>::infinity();

  Floats best = {far, far, far, far};
  Ints best_at = {0, 0, 0, 0};
  Ints at = {0, 1, 2, 3};
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    Floats dx;
    Floats dy;
    std::memcpy(&dx, xs + i, sizeof dx);
    std::memcpy(&dy, ys + i, sizeof dy);
    dx -= fx;
    dy -= fy;
    const Floats d = dx * dx + dy * dy;
    const Ints nearer = d < best;
    best = nearer ? d : best;
    best_at = nearer ? at : best_at;
    at += static_cast<std::int32_t>(lanes);
  }
  std::size_t index = 0;
  float smallest = far;
  const auto consider = [&](float d, std::size_t k) {
    if (d >= smallest) return;
    smallest = d;
    index = k;
  };
  for (std::size_t k = 0; k < lanes; ++k) consider(best[k], static_cast<std::size_t>(best_at[k]));
  for (; i < n; ++i) consider((xs[i] - fx) * (xs[i] - fx) + (ys[i] - fy) * (ys[i] - fy), i);
  return {index, std::sqrt(static_cast<double>(smallest))};
}

void move_walls(const Pose2& motion, double dt, WallsSeen& walls) noexcept {
  move_side(motion, dt, walls.left);
  move_side(motion, dt, walls.right);
}

}  // namespace firstlap
