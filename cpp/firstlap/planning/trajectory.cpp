#include "firstlap/planning/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

// Distance of p to the half-line from a through b.
double ray_distance(const Point2& a, const Point2& b, const Point2& p) noexcept {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double along = dx * (p.x - a.x) + dy * (p.y - a.y);
  const double length2 = dx * dx + dy * dy;
  if (along <= 0.0 || length2 <= 0.0) return distance(a, p);
  return std::abs(dx * (p.y - a.y) - dy * (p.x - a.x)) / std::sqrt(length2);
}

// Projection of base_link onto a line.
struct Foot {
  double along = 0.0;   // [m] arc length from the line's first point
  double offset = 0.0;  // [m] of base_link, left of the line positive
  double dx = 0.0;      // [m] the line segment there
  double dy = 0.0;
};

template <class Point>
Foot foot_of_car(const Buffer<Point>& points) noexcept {
  Foot best;
  double best_distance = 1e18;
  double along = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double dx = points[i + 1].x - points[i].x;
    const double dy = points[i + 1].y - points[i].y;
    const double length = std::max(norm(dx, dy), 1e-9);
    const double rx = -points[i].x;
    const double ry = -points[i].y;
    const double t = std::clamp((rx * dx + ry * dy) / length, 0.0, length);
    const double gap = norm(rx - t * dx / length, ry - t * dy / length);
    if (gap < best_distance) {
      best_distance = gap;
      best = {along + t, (dx * ry - dy * rx) / length, dx, dy};
    }
    along += length;
  }
  return best;
}

// Moves each point toward the line until it keeps `clearance` [m] from the walls, as far as the line itself does.
void keep_between_walls(const Buffer<CenterlinePoint>& line, double clearance, Buffer<Point2>& points) noexcept {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double dx = points[i].x - line[i].x;
    const double dy = points[i].y - line[i].y;
    const double slack = std::max(0.0, clearance_at(line[i]) - clearance);
    if (dx * dx + dy * dy <= slack * slack) continue;
    const double share = slack / norm(dx, dy);
    points[i] = {line[i].x + share * dx, line[i].y + share * dy};
  }
}

}  // namespace

double clearance_at(const CenterlinePoint& point) noexcept {
  if (point.support == WallSupport::both) return 0.5 * point.width;
  const double right = norm(point.x - point.right.x, point.y - point.right.y);
  const double left = norm(point.x - point.left.x, point.y - point.left.y);
  return std::min({0.5 * point.width, right, left});
}

void smooth(double lambda, int iterations, Buffer<Point2>& points) noexcept {
  for (int k = 0; k < iterations; ++k) {
    Point2 before = points.empty() ? Point2{} : points[0];
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
      const Point2 here = points[i];
      const Point2 middle{0.5 * (before.x + points[i + 1].x), 0.5 * (before.y + points[i + 1].y)};
      points[i] = {here.x + lambda * (middle.x - here.x), here.y + lambda * (middle.y - here.y)};
      before = here;
    }
  }
}

void smooth_between_walls(const Buffer<CenterlinePoint>& line, const CarGeometry& car, const TrajectoryParams& params,
                          Buffer<Point2>& points) noexcept {
  points.clear();
  for (const CenterlinePoint& p : line) points.push({p.x, p.y});
  if (params.smoothing_block == 0) return smooth(params.smoothing_lambda, params.smoothing_iterations, points);
  for (int left = params.smoothing_iterations; left > 0; left -= params.smoothing_block) {
    smooth(params.smoothing_lambda, std::min(left, params.smoothing_block), points);
    keep_between_walls(line, 0.5 * car.width + params.smoothing_margin, points);
  }
}

void join_car(double join_distance, double join_angle, Buffer<Point2>& points) noexcept {
  if (points.size() < 3 || join_distance <= 0.0) return;
  const Foot foot = foot_of_car(points);
  const double slope = std::tan(std::clamp(-std::atan2(foot.dy, foot.dx), -join_angle, join_angle));
  double along = 0.0;
  Point2 before = points[0];
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point2 here = points[i];
    along += i > 0 ? distance(here, before) : 0.0;
    const double h = along - foot.along;
    if (h >= join_distance) break;
    const double t = std::max(h, 0.0) / join_distance;
    const double t3 = t * t * t;
    const double offset = h < 0.0 ? foot.offset + slope * h
                                  : foot.offset * (1.0 - 10.0 * t3 + 15.0 * t3 * t - 6.0 * t3 * t * t) +
                                        slope * join_distance * (t - 6.0 * t3 + 8.0 * t3 * t - 3.0 * t3 * t * t);
    const double tx = points[i + 1].x - before.x;
    const double ty = points[i + 1].y - before.y;
    const double length = std::max(norm(tx, ty), 1e-9);
    points[i] = {here.x - offset * ty / length, here.y + offset * tx / length};
    before = here;
  }
}

void join_previous(const Buffer<TrajectoryPoint>& previous, double reach, Buffer<Point2>& points) noexcept {
  if (points.size() < 3 || reach <= 0.0) return;
  const Foot foot = foot_of_car(points);
  const double car_off_path = previous.size() < 2 ? 0.0 : foot_of_car(previous).offset;
  const double residual = foot.offset - car_off_path;  // of the previous path, left of the line positive
  double along = 0.0;
  Point2 before = points[0];
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Point2 here = points[i];
    along += i > 0 ? distance(here, before) : 0.0;
    const double offset = residual * std::exp(-std::max(along - foot.along, 0.0) / reach);
    const double tx = points[i + 1].x - before.x;
    const double ty = points[i + 1].y - before.y;
    const double length = std::max(norm(tx, ty), 1e-9);
    points[i] = {here.x - offset * ty / length, here.y + offset * tx / length};
    before = here;
  }
}

void simplify_opheim(const Buffer<Point2>& points, double tol_min, double tol_max, Buffer<Point2>& knots) noexcept {
  const std::size_t n = points.size();
  if (n < 3 || tol_min <= 0.0 || tol_max <= 0.0) {
    knots.assign(points.span());
    return;
  }
  knots.clear();
  knots.push(points[0]);
  std::size_t r0 = 0;
  std::size_t r1 = 0;
  bool ray = false;
  std::size_t pj = 1;
  for (std::size_t j = 2; j < n; ++j) {
    const std::size_t pi = pj;
    pj = j;
    if (!ray) {
      if (distance(points[r0], points[pj]) < tol_min) continue;
      r1 = pi;
      ray = true;
    }
    if (distance(points[r0], points[pj]) < tol_max && ray_distance(points[r0], points[r1], points[pj]) < tol_min)
      continue;
    knots.push(points[pi]);
    r0 = pi;
    ray = false;
  }
  knots.push(points[n - 1]);
}

void sample_path(const Buffer<Point2>& knots, double sample, double end_hold, Spline& spline,
                 Buffer<TrajectoryPoint>& path) noexcept {
  path.clear();
  if (!spline.fit(knots)) return;
  std::size_t hint = 0;
  const auto pieces = static_cast<std::size_t>(spline.length() / sample);
  for (std::size_t i = 0; i <= pieces; ++i) {
    const SplineSample p = spline.at(static_cast<double>(i) * sample, hint);
    const double step = i == 0 ? 0.0 : norm(p.x - path.back().x, p.y - path.back().y);
    const double s = i == 0 ? 0.0 : path.back().s + step;
    if (!path.push({s, p.x, p.y, p.yaw, p.curvature, 0.0})) break;
  }
  const auto held = static_cast<std::size_t>(end_hold / sample);
  if (path.size() <= held + 1) return;
  const std::size_t from = path.size() - 1 - held;
  for (std::size_t i = from + 1; i < path.size(); ++i) path[i].curvature = path[from].curvature;
}

std::size_t nearest_on_path(const Buffer<TrajectoryPoint>& path, double x, double y) noexcept {
  std::size_t best = 0;
  double best_distance = 1e18;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double dx = path[i].x - x;
    const double dy = path[i].y - y;
    if (dx * dx + dy * dy < best_distance) {
      best_distance = dx * dx + dy * dy;
      best = i;
    }
  }
  return best;
}

}  // namespace firstlap
