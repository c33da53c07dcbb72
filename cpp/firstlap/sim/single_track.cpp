// The single-track model with nonlinear tires: Rajamani, Vehicle Dynamics and Control, 2nd ed., ch. 2 and 13,
// with F_x from the speed loop, static load transfer and a friction ellipse per axle.
#include <algorithm>
#include <cmath>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/sim/vehicle.hpp"

namespace firstlap::sim {
namespace {

constexpr double gravity = 9.81;           // [m/s^2]
constexpr double kinematic_settle = 0.02;  // [s] time constant with which slip decays below the kinematic speed

struct Axle {
  double load = 0.0;          // F_z [N]
  double limit = 0.0;         // [N] maximum force in any direction
  double longitudinal = 0.0;  // [N] F_x, along the wheel
};

struct Axles {
  Axle front, rear;
};

// [m/s^2] Output of the speed loop, limited by motor, brake and grip.
double wanted_acceleration(const VehicleParams& p, double speed, double speed_command) noexcept {
  const double target = std::clamp(speed_command, -p.reverse_speed_max, p.speed_max);
  const double wanted = std::clamp(p.speed_gain * (target - speed), -p.brake_max, p.accel_max);
  const double grip = p.drive_grip * p.friction * gravity;
  return std::clamp(wanted, -grip, grip);
}

Axle make_axle(const VehicleParams& p, double load, double peak, double force) noexcept {
  const double carried = std::max(load, 0.0), limit = p.friction * peak * carried;
  return {carried, limit, std::clamp(force, -p.drive_grip * limit, p.drive_grip * limit)};
}

// F_zf = m (g l_r - a h) / L, F_zr = m (g l_f + a h) / L.
Axles make_axles(const VehicleParams& p, double a) noexcept {
  const double wheelbase = p.l_f + p.l_r, force = p.mass * a;
  const double front_load = p.mass * (gravity * p.l_r - a * p.cg_height) / wheelbase;
  const double rear_load = p.mass * (gravity * p.l_f + a * p.cg_height) / wheelbase;
  return {make_axle(p, front_load, p.front_d, p.drive_split * force),
          make_axle(p, rear_load, p.rear_d, (1.0 - p.drive_split) * force)};
}

// F_y [N] of an axle, left positive, from the velocity of its center in the wheel's frame.
double lateral_force(const VehicleParams& p, const Tire& tire, const Axle& axle, double along, double across) noexcept {
  const double slip_angle = -std::atan2(across, std::abs(along));
  const double left_over = friction_ellipse(axle.longitudinal, axle.limit);
  return p.friction * axle.load * magic_formula(tire, slip_angle) * left_over;
}

// Velocity derivatives with tire slip.
void add_dynamic(const VehicleParams& p, const BodyState& q, const Axles& axles, double weight, BodyState& d) noexcept {
  const double c = std::cos(q.steering), s = std::sin(q.steering);
  const double front_across = q.lateral + p.l_f * q.yaw_rate, rear_across = q.lateral - p.l_r * q.yaw_rate;
  const double front =
      lateral_force(p, p.front_tire(), axles.front, q.forward * c + front_across * s, front_across * c - q.forward * s);
  const double rear = lateral_force(p, p.rear_tire(), axles.rear, q.forward, rear_across);
  const double front_x = axles.front.longitudinal * c - front * s, front_y = axles.front.longitudinal * s + front * c;
  d.forward += weight * ((front_x + axles.rear.longitudinal) / p.mass + q.lateral * q.yaw_rate);
  d.lateral += weight * ((front_y + rear) / p.mass - q.forward * q.yaw_rate);
  d.yaw_rate += weight * (p.l_f * front_y - p.l_r * rear) / p.yaw_inertia;
}

// Velocity derivatives without slip: yaw rate v tan(delta) / L, lateral speed l_r times that.
void add_kinematic(const VehicleParams& p, const BodyState& q, const Axles& axles, double weight,
                   BodyState& d) noexcept {
  const double wheelbase = p.l_f + p.l_r, tangent = std::tan(q.steering);
  const double a = (axles.front.longitudinal + axles.rear.longitudinal) / p.mass;
  const double yaw_rate = q.forward * tangent / wheelbase;
  const double yaw_acceleration = (a * tangent + q.forward * d.steering * (1.0 + tangent * tangent)) / wheelbase;
  d.forward += weight * a;
  d.yaw_rate += weight * (yaw_acceleration + (yaw_rate - q.yaw_rate) / kinematic_settle);
  d.lateral += weight * (p.l_r * yaw_acceleration + (p.l_r * yaw_rate - q.lateral) / kinematic_settle);
}

// 0 up to the kinematic speed, 1 above 1.5 times that, smooth in between.
double dynamic_weight(const VehicleParams& p, const BodyState& q) noexcept {
  const double speed = std::hypot(q.forward, q.lateral);
  const double t = std::clamp((speed - p.kinematic_below) / (0.5 * p.kinematic_below), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

BodyState single_track_derivative(const CarGeometry& geometry, const VehicleParams& params, const BodyState& state,
                                  double speed_command, double steering_command) noexcept {
  const double c = std::cos(state.yaw), s = std::sin(state.yaw);
  const double target = std::clamp(steering_command, -geometry.steering_limit, geometry.steering_limit);
  BodyState d{.x = state.forward * c - state.lateral * s,
              .y = state.forward * s + state.lateral * c,
              .yaw = state.yaw_rate,
              .steering = std::clamp((target - state.steering) / params.servo_time_constant, -geometry.steering_rate,
                                     geometry.steering_rate)};
  const Axles axles = make_axles(params, wanted_acceleration(params, state.forward, speed_command));
  const double weight = dynamic_weight(params, state);
  if (weight > 0.0) add_dynamic(params, state, axles, weight, d);
  if (weight < 1.0) add_kinematic(params, state, axles, 1.0 - weight, d);
  return d;
}

}  // namespace firstlap::sim
