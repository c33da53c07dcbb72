#include "firstlap/mapping/scan_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/mapping/linear3.hpp"

namespace firstlap::mapping {
namespace {

constexpr double cell = 0.25;    // [m]
constexpr int max_cells = 4000;  // along each side

struct Frame {
  explicit Frame(const Pose2& p) : x(p.x), y(p.y), c(std::cos(p.yaw)), s(std::sin(p.yaw)) {}
  double x, y, c, s;
};

// Adds the prior: the deviation of the pose from the guess, in the cloud's frame.
void add_prior(Normal3& normal, const Pose2& pose, const Pose2& guess, const Prior& prior) {
  const double turn = wrap_angle(pose.yaw - guess.yaw), c = std::cos(guess.yaw), s = std::sin(guess.yaw);
  const double dx = pose.x - guess.x, dy = pose.y - guess.y;
  const double along = c * dx + s * dy, across = -s * dx + c * dy, ct = std::cos(turn), st = std::sin(turn);
  normal.add(ct, -st, 0.0, along, 1.0 / (prior.along * prior.along));
  normal.add(st, ct, 0.0, across, 1.0 / (prior.across * prior.across));
  normal.add(0.0, 0.0, 1.0, turn, 1.0 / (prior.yaw * prior.yaw));
}

// One iteration: the residuals are distances to the line through the corresponding point, with Cauchy weights. Also
// computes fit and rms.
Normal3 gather(std::span<const CloudPoint> cloud, const ReferenceCloud& reference, const MatchParams& params,
               double reach, Match& result) {
  Normal3 normal;
  const Frame f(result.pose);
  const double min_cosine = std::cos(params.normal_angle);
  int with_normal = 0, fitting = 0;
  double squares = 0.0;
  for (const CloudPoint& p : cloud) {
    if (p.nx == 0.0 && p.ny == 0.0) continue;
    ++with_normal;
    const double x = f.x + f.c * p.x - f.s * p.y, y = f.y + f.s * p.x + f.c * p.y;
    const Point2 turned{f.c * p.nx - f.s * p.ny, f.s * p.nx + f.c * p.ny};
    const CloudPoint* q = reference.nearest({x, y}, turned, reach, min_cosine);
    if (q == nullptr) continue;
    const double e = q->nx * (x - q->x) + q->ny * (y - q->y), ratio = e / params.sigma;
    const double nx = f.c * q->nx + f.s * q->ny, ny = -f.s * q->nx + f.c * q->ny;  // in the cloud's frame
    normal.add(nx, ny, ny * p.x - nx * p.y, e, 1.0 / (params.sigma * params.sigma * (1.0 + ratio * ratio)));
    if (std::abs(e) > params.inlier_distance) continue;
    ++fitting;
    squares += e * e;
  }
  result.fit = with_normal > 0 ? static_cast<double>(fitting) / with_normal : 0.0;
  result.rms = fitting > 0 ? std::sqrt(squares / fitting) : 0.0;
  return normal;
}

bool usable(const CloudPoint& p) noexcept {
  return (p.nx != 0.0 || p.ny != 0.0) && std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6;
}

}  // namespace

// Lays out the grid around the usable points; false if there is none.
bool ReferenceCloud::bound(std::span<const CloudPoint> points) noexcept {
  double x_max = -1e300, y_max = -1e300;
  x_min_ = y_min_ = 1e300;
  for (const CloudPoint& p : points) {
    if (!usable(p)) continue;
    x_min_ = std::min(x_min_, p.x);
    y_min_ = std::min(y_min_, p.y);
    x_max = std::max(x_max, p.x);
    y_max = std::max(y_max, p.y);
  }
  if (x_max < x_min_) return false;
  columns_ = std::min(static_cast<int>((x_max - x_min_) / cell) + 1, max_cells);
  rows_ = std::min(static_cast<int>((y_max - y_min_) / cell) + 1, max_cells);
  return true;
}

// Counting sort of the points into cells.
ReferenceCloud::ReferenceCloud(std::span<const CloudPoint> points) {
  if (!bound(points)) return;
  begin_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const CloudPoint& p : points) {
    if (usable(p)) ++begin_[cell_of(p) + 1];
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  points_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (const CloudPoint& p : points) {
    if (usable(p)) points_[next[cell_of(p)]++] = p;
  }
}

std::size_t ReferenceCloud::cell_of(const CloudPoint& p) const noexcept {
  return static_cast<std::size_t>(std::clamp(row(p.y), 0, rows_ - 1)) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(std::clamp(column(p.x), 0, columns_ - 1));
}

int ReferenceCloud::column(double x) const noexcept {
  return static_cast<int>(std::floor(std::clamp((x - x_min_) / cell, -1e6, 1e6)));
}

int ReferenceCloud::row(double y) const noexcept {
  return static_cast<int>(std::floor(std::clamp((y - y_min_) / cell, -1e6, 1e6)));
}

const CloudPoint* ReferenceCloud::nearest(Point2 at, Point2 normal, double reach, double min_cosine) const noexcept {
  const auto [x, y] = at;
  const CloudPoint* best = nullptr;
  if (points_.empty()) return best;
  double best_squared = reach * reach;
  const int c0 = std::max(column(x - reach), 0), c1 = std::min(column(x + reach), columns_ - 1);
  const int r0 = std::max(row(y - reach), 0), r1 = std::min(row(y + reach), rows_ - 1);
  if (c0 > c1) return best;
  for (int r = r0; r <= r1; ++r) {
    const std::size_t start = static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_);
    const std::size_t end = begin_[start + static_cast<std::size_t>(c1) + 1];
    for (std::size_t i = begin_[start + static_cast<std::size_t>(c0)]; i < end; ++i) {
      const CloudPoint& q = points_[i];
      const double dx = q.x - x, dy = q.y - y, squared = dx * dx + dy * dy;
      if (squared >= best_squared || q.nx * normal.x + q.ny * normal.y < min_cosine) continue;
      best_squared = squared;
      best = &q;
    }
  }
  return best;
}

Match match(std::span<const CloudPoint> cloud, const ReferenceCloud& reference, const Pose2& guess, const Prior& prior,
            const MatchParams& params) noexcept {
  Match result{.pose = guess};
  double reach = params.reach_first;
  const double shrink = 0.7;
  while (result.iterations < params.iterations) {
    ++result.iterations;
    Normal3 normal = gather(cloud, reference, params, reach, result);
    add_prior(normal, result.pose, guess, prior);
    const auto step = normal.solve();
    const double c = std::cos(result.pose.yaw), s = std::sin(result.pose.yaw);
    result.pose = {result.pose.x + c * step[0] - s * step[1], result.pose.y + s * step[0] + c * step[1],
                   wrap_angle(result.pose.yaw + step[2])};
    const bool settled = norm(step[0], step[1]) < 1e-4 && std::abs(step[2]) < 1e-4;
    if (settled && reach <= params.reach_last) break;
    reach = std::max(reach * (settled ? 0.5 * shrink : shrink), params.reach_last);
  }
  result.information = gather(cloud, reference, params, params.reach_last, result).h;
  return result;
}

}  // namespace firstlap::mapping
