#include "firstlap/drivers/reactive_control.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firstlap/common/geometry.hpp"

namespace firstlap::drivers {
namespace {

constexpr double straight = 1e-4;  // [1/m] smaller curvatures count as straight
constexpr double passed = -0.05;   // [m] a point farther behind the front edge of the body is beside it, not ahead

// Free distance [m] straight ahead.
double free_straight(const Buffer<Point2>& points, double side, double front, double farthest) noexcept {
  double free = farthest;
  for (const Point2& p : points)
    if (std::abs(p.y) < side && p.x - front > passed) free = std::min(free, std::max(p.x - front, 0.0));
  return free;
}

}  // namespace

double plan_speed(double free, double curvature, const SpeedNow& now, const SpeedParams& params) noexcept {
  double speed = 0.0;
  if (free > params.stop_distance) {
    const double braking = std::sqrt(-2.0 * params.a_x_min * (free - params.stop_distance));
    const double turning = std::sqrt(params.a_y_max / std::max(std::abs(curvature), straight));
    speed = std::max(std::min({braking, turning, params.v_max}), std::min(params.v_min, params.v_max));
  }
  // The limit on deceleration does not apply to a stop.
  const double softened = std::min(now.measured + params.delta_v_min, now.commanded + params.a_x_min * now.dt);
  const double slowest = speed > 0.0 ? softened : 0.0;
  return std::clamp(std::min(std::max(speed, slowest), now.measured + params.delta_v_max), 0.0, params.v_max);
}

double within_grip(double wanted, double speed, const SteeringParams& params, const CarGeometry& car) noexcept {
  const double grip = std::atan(car.wheelbase * params.a_y_steer / std::max(speed * speed, 1e-3));
  const double limit = std::min(car.steering_limit, grip);
  return std::clamp(wanted, -limit, limit);
}

double smooth_steering(double wanted, double before, double dt, double time, const CarGeometry& car) noexcept {
  const double share = time > 0.0 ? dt / (time + dt) : 1.0;
  const double step = car.steering_rate * dt;
  const double angle = std::clamp(before + share * (wanted - before), before - step, before + step);
  return std::clamp(angle, -car.steering_limit, car.steering_limit);
}

double curvature_of(double steering_angle, const CarGeometry& car) noexcept {
  return std::tan(steering_angle) / car.wheelbase;
}

LateralClearance lateral_clearance(const Buffer<Point2>& points, const CarGeometry& car) noexcept {
  const Footprint body(car);
  LateralClearance beside;
  for (const Point2& p : points) {
    if (p.x < body.rear || p.x > body.front) continue;
    double& side = p.y > 0.0 ? beside.left : beside.right;
    side = std::min(side, std::max(std::abs(p.y) - body.side, 0.0));
  }
  return beside;
}

double margin_beside(const Buffer<Point2>& points, double wanted, const CarGeometry& car) noexcept {
  constexpr double share = 0.8;  // of the clearance
  const LateralClearance beside = lateral_clearance(points, car);
  return std::min(wanted, share * std::min(beside.left, beside.right));
}

double free_along_arc(const Buffer<Point2>& points, double curvature, double margin, double farthest,
                      const CarGeometry& car) noexcept {
  const Footprint body(car);
  const double side = body.side + margin, front = body.front;
  if (std::abs(curvature) < straight) return free_straight(points, side, front, farthest);
  const double radius = 1.0 / std::abs(curvature);
  const double inner = std::max(radius - side, 0.0);
  const double outer = norm(radius + side, front);
  double least = farthest / radius;  // [rad] around the center of the circle
  for (const Point2& p : points) {
    const double y = radius - (curvature > 0.0 ? p.y : -p.y);  // from the center toward the car
    const double square = p.x * p.x + y * y;
    if (square <= inner * inner || square >= outer * outer) continue;
    const double distance = std::sqrt(square);
    // The point of the body that reaches this radius first: the front, or the inner side behind it.
    const double reach = std::min(front, std::sqrt(std::max(square - inner * inner, 0.0)));
    const double angle = std::atan2(p.x, y) - std::asin(std::min(reach / distance, 1.0));
    const double ahead = angle * radius > passed ? std::max(angle, 0.0) : angle + 2.0 * std::numbers::pi;
    least = std::min(least, ahead);
  }
  return least * radius;
}

}  // namespace firstlap::drivers
