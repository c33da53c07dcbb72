#include "firstlap/drivers/center_pid.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/plausible.hpp"
#include "firstlap/drivers/driver_params.hpp"

namespace firstlap::drivers {

void validate(const CenterPidParams& params) { validate_driver(params); }

CenterPid::CenterPid(const CenterPidParams& params) : params_(params) { validate(params); }

WallEstimate estimate_wall(double side, double ahead, const CenterParams& params, double preview) noexcept {
  const double between = params.side_angle - params.ahead_angle;
  WallEstimate wall{.side = side, .ahead = ahead};
  // Angle between the wall and the car's axis, positive away from the car.
  const double x = ahead * std::cos(params.ahead_angle) - side * std::cos(params.side_angle);
  const double y = ahead * std::sin(params.ahead_angle) - side * std::sin(params.side_angle);
  wall.angle = std::atan2(y, std::max(x, 1e-6));
  wall.distance = side * ahead * std::sin(between) / std::max(std::hypot(x, y), 1e-6);
  wall.preview = wall.distance + preview * std::sin(wall.angle);
  return wall;
}

StepResult CenterPid::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  if (!plausible(state, dt)) return stop(0.0, Status::bad_state);
  if (dt > max_pause) reset();
  memory_.period.learn(dt);
  if (!sweep_.read(scan, state, memory_.period, params_.scan, params_.car)) return stop(dt, Status::bad_scan);
  measure(state.speed);
  const CarGeometry& car = params_.car;
  const CenterSteeringParams& p = params_.steering;
  const double wanted = within_grip(control(dt), state.speed, {.a_y_steer = p.a_y_steer}, car);
  memory_.steering = smooth_steering(wanted, memory_.steering, dt, p.steering_time, car);

  const double margin = margin_beside(sweep_.points(), params_.center.arc_margin, car);
  const double curvature = curvature_of(memory_.steering, car);
  trace_.free = free_along_arc(sweep_.points(), curvature, margin, params_.scan.range_use, car);
  memory_.speed = plan_speed(trace_.free, curvature, {state.speed, memory_.speed, dt}, params_.speed);
  const bool blocked = trace_.free <= params_.speed.stop_distance;
  return trace_.result = {{memory_.speed, memory_.steering}, blocked ? Status::blocked : Status::ok};
}

double CenterPid::mean_range(double angle) const noexcept {
  const std::size_t first = sweep_.beam_at(angle - params_.center.beam_window);
  const std::size_t last = sweep_.beam_at(angle + params_.center.beam_window);
  const double most = params_.center.side_range / std::max(std::abs(std::sin(angle)), 1e-3);
  double sum = 0.0;
  for (std::size_t i = first; i <= last; ++i) sum += std::min(sweep_.range(i), most);
  return sum / static_cast<double>(last - first + 1);
}

void CenterPid::measure(double speed) noexcept {
  const CenterParams& p = params_.center;
  trace_.ranges.assign(sweep_.ranges().span());
  trace_.first_beam = sweep_.angle(0);
  trace_.beam_step = sweep_.angle_step();
  trace_.preview = p.preview + p.preview_time * std::max(speed, 0.0);
  trace_.left = estimate_wall(mean_range(p.side_angle), mean_range(p.ahead_angle), p, trace_.preview);
  trace_.right = estimate_wall(mean_range(-p.side_angle), mean_range(-p.ahead_angle), p, trace_.preview);
  trace_.error = std::clamp(0.5 * (trace_.left.preview - trace_.right.preview), -p.error_limit, p.error_limit);
}

double CenterPid::control(double dt) noexcept {
  constexpr double most = 0.2;       // [rad] limit of the integral term (anti-windup)
  constexpr double shortest = 1e-3;  // [s] minimum interval for a derivative
  const CenterParams& p = params_.center;
  const double change = memory_.initialized && dt > shortest ? (trace_.error - memory_.error) / dt : 0.0;
  memory_.derivative += dt / (p.derivative_time + std::max(dt, shortest)) * (change - memory_.derivative);
  memory_.integral = std::clamp(memory_.integral + p.k_i * trace_.error * dt, -most, most);
  memory_.error = trace_.error;
  memory_.initialized = true;
  trace_.integral = memory_.integral;
  trace_.derivative = memory_.derivative;
  trace_.p_term = p.k_p * trace_.error;
  trace_.i_term = memory_.integral;
  trace_.d_term = p.k_d * memory_.derivative;
  return trace_.p_term + trace_.i_term + trace_.d_term;
}

StepResult CenterPid::stop(double dt, Status why) noexcept {
  const double angle = smooth_steering(memory_.steering, memory_.steering, dt, 0.0, params_.car);
  memory_ = {.steering = angle, .speed = 0.0, .period = memory_.period};
  return trace_.result = {{0.0, angle}, why};
}

}  // namespace firstlap::drivers
