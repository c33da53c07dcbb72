#include "firstlap/control/stanley.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

// Lower bounds of divisors.
constexpr double min_speed = 0.1;  // [m/s]
constexpr double min_gain = 0.05;
constexpr double min_step = 1e-9;  // [m]

// Mean |curvature| [1/m] over the next `length` [m].
double mean_curvature(const Buffer<TrajectoryPoint>& path, std::size_t from, double length) noexcept {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = from; i < path.size() && path[i].s <= path[from].s + length; ++i) {
    sum += std::abs(path[i].curvature);
    count += 1.0;
  }
  return sum / std::max(count, 1.0);
}

TrajectoryPoint point_at(const Buffer<TrajectoryPoint>& path, std::size_t from, double s) noexcept {
  std::size_t i = from;
  while (i + 1 < path.size() && path[i + 1].s < s) ++i;
  if (i + 1 >= path.size()) return path.back();
  const TrajectoryPoint& a = path[i];
  const TrajectoryPoint& b = path[i + 1];
  const double t = std::clamp((s - a.s) / std::max(b.s - a.s, min_step), 0.0, 1.0);
  return {s,
          a.x + t * (b.x - a.x),
          a.y + t * (b.y - a.y),
          a.yaw + t * wrap_angle(b.yaw - a.yaw),
          a.curvature + t * (b.curvature - a.curvature),
          a.velocity + t * (b.velocity - a.velocity)};
}

// Sets the heading gain and the lookahead at speed `v` [m/s].
void schedule(const TrackedPath& tracked, double v, const StanleyParams& params, const CarGeometry& car,
              SteeringTerms& terms) noexcept {
  const auto& [path, from, state, previous_steering] = tracked;
  terms.k_ang = params.k_ang;
  terms.lookahead = params.l_max / (1.0 + mean_curvature(path, from, params.l_max) / params.kappa_n);
  if (params.schedule_omega <= 0.0) return;
  // Keep the crossover of the heading loop at schedule_omega, with the lookahead for which a steady curve is neutral.
  terms.k_ang = std::min(params.k_ang, params.schedule_omega * car.wheelbase / std::max(v, min_speed));
  terms.lookahead = std::clamp(car.wheelbase * (1.0 / std::max(terms.k_ang, min_gain) - 1.0), 0.0, params.l_max);
}

}  // namespace

SteeringTerms track_path(const TrackedPath& tracked, const StanleyParams& params, const CarGeometry& car,
                         TrajectoryPoint& point) noexcept {
  const auto& [path, from, state, previous_steering] = tracked;
  const double v = std::max(state.speed, 0.0);
  SteeringTerms terms;
  schedule(tracked, v, params, car, terms);
  point = point_at(path, from, path[from].s + terms.lookahead);

  terms.heading_error = wrap_angle(point.yaw) + params.k_ag * v * v * point.curvature;
  terms.cross_track_error = std::cos(point.yaw) * point.y - std::sin(point.yaw) * (point.x - car.wheelbase);
  const double reference[] = {v * point.curvature, v * path[from].curvature, 0.0};
  terms.yaw_rate_error = state.yaw_rate - reference[std::clamp(params.rate_reference, 0, 2)];
  terms.steering_change = state.steering_angle - previous_steering;

  terms.heading = terms.k_ang * terms.heading_error;
  terms.cross_track = std::atan(params.k_dist * terms.cross_track_error / (params.k_damp * v + params.k_soft));
  terms.yaw_rate = params.k_rate * terms.yaw_rate_error;
  terms.steering = params.k_steer * terms.steering_change;
  terms.steering_angle = terms.heading + terms.cross_track + terms.yaw_rate + terms.steering;
  return terms;
}

}  // namespace firstlap
