#include "firstlap/perception/local_walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include "firstlap/common/geometry.hpp"

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
    const Sight past = side.sight[i];
    const auto fc = static_cast<float>(c);
    const auto fs = static_cast<float>(s);
    if (past.shadow != 0.0F)
      side.sight[i] = {fc * past.x + fs * past.y, -fs * past.x + fc * past.y, past.shadow, past.track_continues};
    side.age[i] += static_cast<float>(dt);
  }
}

}  // namespace

void WallSide::clear() noexcept {
  x.clear();
  y.clear();
  outward.clear();
  sight.clear();
  age.clear();
  seen = 0;
}

void WallSide::push(double px, double py, Point2 out, float seen_before, Sight past) noexcept {
  x.push(static_cast<float>(px));
  y.push(static_cast<float>(py));
  outward.push(out);
  sight.push(past);
  age.push(seen_before);
}

namespace {

// Vector extensions that gcc and clang support on every processor: a scalar search would take half the time of a step.
constexpr std::size_t lanes = 4;
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));

Floats load(const float* from) noexcept {
  Floats floats;
  std::memcpy(&floats, from, sizeof floats);
  return floats;
}

// Element-wise minimum. gcc does not find the x86 instruction for it.
Floats smaller(Floats a, Floats b) noexcept {
#ifdef __SSE__
  return _mm_min_ps(a, b);
#else
  return a < b ? a : b;
#endif
}

// Search for the sample nearest to (x, y), block by block. Each lane keeps its smallest squared distance and the block
// where it was found.
class Search {
 public:
  static constexpr std::size_t block = 2 * lanes;  // samples

  Search(const WallSide& side, double x, double y) noexcept
      : xs_(side.x.data()), ys_(side.y.data()), x_(static_cast<float>(x)), y_(static_cast<float>(y)) {}

  void test_block(std::size_t first) noexcept {
    const Floats d = smaller(squared_distances(first), squared_distances(first + lanes));
    const Ints nearer = d < best_;
    const Ints here = Ints{} + static_cast<std::int32_t>(first);
    best_ = smaller(d, best_);
    block_ = (nearer & here) | (~nearer & block_);
  }
  // For fewer samples than a block.
  void test(std::size_t i) noexcept {
    const float d = squared_distance(i);
    if (d >= best_[0]) return;
    best_[0] = d;
    block_[0] = static_cast<std::int32_t>(i);
  }
  [[nodiscard]] Nearest nearest() const noexcept {
    std::size_t lane = 0;
    for (std::size_t k = 1; k < lanes; ++k)
      if (best_[k] < best_[lane]) lane = k;
    std::size_t index = static_cast<std::size_t>(block_[lane]) + lane;
    if (squared_distance(index) != best_[lane]) index += lanes;
    return {index, std::sqrt(static_cast<double>(best_[lane]))};
  }

 private:
  [[nodiscard]] Floats squared_distances(std::size_t first) const noexcept {
    const Floats dx = load(xs_ + first) - x_;
    const Floats dy = load(ys_ + first) - y_;
    return dx * dx + dy * dy;
  }
  [[nodiscard]] float squared_distance(std::size_t i) const noexcept {
    const float dx = xs_[i] - x_;
    const float dy = ys_[i] - y_;
    return dx * dx + dy * dy;
  }

  static constexpr float far = std::numeric_limits<float>::infinity();
  const float* xs_;
  const float* ys_;
  float x_;
  float y_;
  Floats best_ = {far, far, far, far};
  Ints block_ = {0, 0, 0, 0};
};

Nearest nearest_of_first(std::size_t n, const WallSide& side, double x, double y) noexcept {
  if (n == 0) return {0, std::numeric_limits<double>::infinity()};
  Search search(side, x, y);
  if (n < Search::block) {
    for (std::size_t i = 0; i < n; ++i) search.test(i);
    return search.nearest();
  }
  std::size_t i = 0;
  for (; i + Search::block <= n; i += Search::block) search.test_block(i);
  if (i < n) search.test_block(n - Search::block);  // overlaps the previous block
  return search.nearest();
}

}  // namespace

std::vector<Point2> WallSide::points() const {
  std::vector<Point2> result;
  result.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) result.push_back(at(i));
  return result;
}

Nearest nearest_sample(const WallSide& side, double px, double py) noexcept {
  return nearest_of_first(side.size(), side, px, py);
}

Nearest WallSearch::nearest(double x, double y) noexcept { return nearest_of_first(count_, side_, x, y); }

Nearest WallSearch::nearest_onwards(double x, double y, double reach) noexcept {
  if (count_ == 0) return nearest(x, y);
  const auto square = [&](std::size_t i) {
    const double dx = x - static_cast<double>(side_.x[i]);
    const double dy = y - static_cast<double>(side_.y[i]);
    return dx * dx + dy * dy;
  };
  double best = square(last_);
  const auto take = [&](std::size_t i) {
    const double there = square(i);
    if (there >= best) return false;
    best = there;
    last_ = i;
    return true;
  };
  while (last_ + 1 < count_ && take(last_ + 1)) continue;
  while (last_ > 0 && take(last_ - 1)) continue;
  if (best <= reach * reach) return {last_, std::sqrt(best)};
  const Nearest of_all = nearest(x, y);
  last_ = of_all.index;
  return of_all;
}

double WallSearch::distance(double x, double y, double enough) noexcept {
  constexpr std::size_t reach = 3;  // samples tried first
  for (std::size_t i = last_; i < std::min(last_ + reach, count_); ++i) {
    const double d = norm(x - side_.at(i).x, y - side_.at(i).y);
    if (d >= enough) continue;
    last_ = i;
    return d;
  }
  const Nearest nearest = nearest_of_first(count_, side_, x, y);
  last_ = nearest.index;
  return nearest.distance;
}

void move_walls(const Pose2& motion, double dt, LocalWalls& walls) noexcept {
  move_side(motion, dt, walls.left);
  move_side(motion, dt, walls.right);
}

}  // namespace firstlap
