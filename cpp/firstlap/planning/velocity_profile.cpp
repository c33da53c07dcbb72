#include "firstlap/planning/velocity_profile.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap {
namespace {

// Share of the longitudinal limit that cornering at speed v leaves; 1 in the paper.
double grip_left(double v, double curvature, const VelocityProfileParams& params) noexcept {
  if (!params.friction_ellipse) return 1.0;
  const double used = std::min(1.0, v * v * std::abs(curvature) / params.a_y_max);
  return std::sqrt(1.0 - used * used);
}

double cornering_speed(double curvature, const VelocityProfileParams& params) noexcept {
  return std::sqrt(params.a_y_max / std::max(std::abs(curvature), 1e-4));
}

double next_speed(double v, double s, double acceleration, double cornering,
                  const VelocityProfileParams& params) noexcept {
  const double reached = std::sqrt(v * v + 2.0 * s * acceleration);
  return std::max(params.v_min, std::min({params.v_max, reached, cornering}));
}

// Forward pass, from the speed of the car.
void accelerate(double speed, std::size_t from, const VelocityProfileParams& params,
                Buffer<TrajectoryPoint>& path) noexcept {
  const std::size_t n = path.size();
  for (std::size_t i = 0; i <= from && i < n; ++i) path[i].velocity = std::max(speed, params.v_standing);
  for (std::size_t i = from + 1; i < n; ++i) {
    const TrajectoryPoint& p = path[i - 1];
    const double a = params.a_x_max * grip_left(p.velocity, p.curvature, params);
    path[i].velocity = next_speed(p.velocity, path[i].s - p.s, a, cornering_speed(path[i].curvature, params), params);
  }
}

// Backward pass. Anything may be beyond the horizon, so it starts at v_min.
void brake(std::size_t from, const VelocityProfileParams& params, Buffer<TrajectoryPoint>& path) noexcept {
  const std::size_t n = path.size();
  double v = params.v_min;
  path[n - 1].velocity = std::min(path[n - 1].velocity, v);
  for (std::size_t i = n - 1; i-- > from;) {
    const TrajectoryPoint& p = path[i + 1];
    const double a = -params.a_x_min * grip_left(v, p.curvature, params);
    v = next_speed(v, p.s - path[i].s, a, cornering_speed(path[i].curvature, params), params);
    path[i].velocity = std::min(path[i].velocity, v);
  }
}

// Near the end of the visible track, v_min must not apply.
void slow_to_horizon(std::size_t from, const VelocityProfileParams& params, Buffer<TrajectoryPoint>& path) noexcept {
  const std::size_t n = path.size();
  for (std::size_t i = from; i < n; ++i) {
    const double left = path[n - 1].s - path[i].s;
    const double limit = std::sqrt(params.v_horizon * params.v_horizon - 2.0 * params.a_x_min * left);
    path[i].velocity = std::min(path[i].velocity, limit);
  }
}

}  // namespace

void plan_velocity(double speed, std::size_t from, const VelocityProfileParams& params,
                   Buffer<TrajectoryPoint>& path) noexcept {
  if (path.empty()) return;
  accelerate(speed, from, params, path);
  brake(from, params, path);
  slow_to_horizon(from, params, path);
}

void stop_before(double s, const VelocityProfileParams& params, Buffer<TrajectoryPoint>& path) noexcept {
  for (TrajectoryPoint& p : path)
    p.velocity = std::min(p.velocity, std::sqrt(std::max(0.0, -2.0 * params.a_x_min * (s - p.s))));
}

double command_speed(const Buffer<TrajectoryPoint>& path, std::size_t from, double speed,
                     const VelocityProfileParams& params) noexcept {
  const double s = path[from].s + std::max(speed, params.v_standing) * params.preview_time;
  std::size_t i = from + 1;
  while (i + 1 < path.size() && path[i].s < s) ++i;
  i = std::min(i, path.size() - 1);
  return std::clamp(path[i].velocity, std::max(0.0, speed + params.delta_v_min),
                    std::max(0.0, speed + params.delta_v_max));
}

}  // namespace firstlap
