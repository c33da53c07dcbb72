// f1tenth_gym's car: the single-track model of Althoff and Wuersching, "CommonRoad: Vehicle Models" (2020), section 6,
// with linear tires, and f1tenth_gym's low-level control.
#include <algorithm>
#include <cmath>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/sim/vehicle.hpp"

namespace firstlap::sim {
namespace {

constexpr double gravity = 9.81;         // [m/s^2]
constexpr double kinematic_below = 0.5;  // [m/s]
constexpr double steering_close = 1e-4;  // [rad] error below which the steering rate is 0

double limited_rate(const CarGeometry& geometry, double steering, double rate) noexcept {
  const bool at_right = steering <= -geometry.steering_limit && rate <= 0.0;
  const bool at_left = steering >= geometry.steering_limit && rate >= 0.0;
  return at_right || at_left ? 0.0 : std::clamp(rate, -geometry.steering_rate, geometry.steering_rate);
}

double limited_acceleration(const VehicleParams& p, double speed, double acceleration) noexcept {
  const bool at_slowest = speed <= -p.reverse_speed_max && acceleration <= 0.0;
  const bool at_fastest = speed >= p.speed_max && acceleration >= 0.0;
  if (at_slowest || at_fastest) return 0.0;
  const double most = speed > p.gym_switch_speed ? p.accel_max * p.gym_switch_speed / speed : p.accel_max;
  return std::clamp(acceleration, -p.brake_max, most);
}

// Without side slip, below kinematic_below.
GymState kinematic_derivative(const GymState& state, double wheelbase, double rate, double a) noexcept {
  const double steering = state[2], v = state[3], yaw = state[4];
  const double tangent = std::tan(steering);
  const double yaw_acceleration = (a * tangent + v * rate * (1.0 + tangent * tangent)) / wheelbase;
  return {v * std::cos(yaw), v * std::sin(yaw), rate, a, v * tangent / wheelbase, yaw_acceleration, 0.0};
}

}  // namespace

GymState gym_derivative(const CarGeometry& geometry, const VehicleParams& p, const GymState& state,
                        const GymInput& input) noexcept {
  const auto [x, y, steering, v, yaw, yaw_rate, slip] = state;
  const double rate = limited_rate(geometry, steering, input.steering_rate);
  const double a = limited_acceleration(p, v, input.acceleration);
  const double wheelbase = p.l_f + p.l_r;
  if (std::abs(v) < kinematic_below) return kinematic_derivative(state, wheelbase, rate, a);
  // Cornering stiffness times axle load, each divided by mass / wheelbase.
  const double front = p.gym_stiffness_front * (gravity * p.l_r - a * p.cg_height);
  const double rear = p.gym_stiffness_rear * (gravity * p.l_f + a * p.cg_height);
  const double turn = yaw_rate / v;
  const double moment = p.l_f * front * steering + (p.l_r * rear - p.l_f * front) * slip -
                        (p.l_f * p.l_f * front + p.l_r * p.l_r * rear) * turn;
  const double force = front * steering - (rear + front) * slip + (rear * p.l_r - front * p.l_f) * turn;
  return {v * std::cos(yaw + slip),
          v * std::sin(yaw + slip),
          rate,
          a,
          yaw_rate,
          p.friction * p.mass / (p.yaw_inertia * wheelbase) * moment,
          p.friction / (v * wheelbase) * force - yaw_rate};
}

GymInput gym_control(const CarGeometry& geometry, const VehicleParams& p, const GymState& state, double speed_command,
                     double steering_command) noexcept {
  const double steering_error = steering_command - state[2], speed_error = speed_command - state[3];
  const double rate =
      std::abs(steering_error) > steering_close ? std::copysign(geometry.steering_rate, steering_error) : 0.0;
  const double gain = state[3] > 0.0 ? 10.0 : 2.0;
  const double slowest = std::max(p.reverse_speed_max, 0.1);
  const double per_speed = speed_error > 0.0 ? p.accel_max / p.speed_max : p.accel_max / slowest;
  return {rate, gain * per_speed * speed_error};
}

}  // namespace firstlap::sim
