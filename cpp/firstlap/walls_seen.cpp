#include "firstlap/walls_seen.hpp"

#include <cmath>
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
}

void WallSide::push(double px, double py, Point2 out, float seen_before) noexcept {
  x.push(static_cast<float>(px));
  y.push(static_cast<float>(py));
  outward.push(out);
  age.push(seen_before);
}

Nearest nearest_sample(const WallSide& side, double px, double py) noexcept {
  const std::size_t n = side.size();
  const float* xs = side.x.data();
  const float* ys = side.y.data();
  const auto fx = static_cast<float>(px);
  const auto fy = static_cast<float>(py);
  // Four lanes, written out: the compiler may not reorder a minimum by itself.
  constexpr std::size_t lanes = 4;
  float best[lanes];
  std::int32_t index[lanes];
  for (std::size_t k = 0; k < lanes; ++k) {
    best[k] = std::numeric_limits<float>::infinity();
    index[k] = 0;
  }
  std::size_t i = 0;
  for (; i + lanes <= n; i += lanes) {
    for (std::size_t k = 0; k < lanes; ++k) {
      const float dx = xs[i + k] - fx;
      const float dy = ys[i + k] - fy;
      const float d = dx * dx + dy * dy;
      const bool nearer = d < best[k];
      best[k] = nearer ? d : best[k];
      index[k] = nearer ? static_cast<std::int32_t>(i + k) : index[k];
    }
  }
  for (; i < n; ++i) {
    const float dx = xs[i] - fx;
    const float dy = ys[i] - fy;
    const float d = dx * dx + dy * dy;
    if (d < best[0]) {
      best[0] = d;
      index[0] = static_cast<std::int32_t>(i);
    }
  }
  std::size_t lane = 0;
  for (std::size_t k = 1; k < lanes; ++k)
    if (best[k] < best[lane]) lane = k;
  return {static_cast<std::size_t>(index[lane]), std::sqrt(static_cast<double>(best[lane]))};
}

void move_walls(const Pose2& motion, double dt, WallsSeen& walls) noexcept {
  move_side(motion, dt, walls.left);
  move_side(motion, dt, walls.right);
}

}  // namespace firstlap
