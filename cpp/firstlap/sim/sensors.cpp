#include "firstlap/sim/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firstlap::sim {
namespace {

VehicleState misread(VehicleState state, double yaw, OdometryFault fault) noexcept {
  constexpr double km_h_per_m_s = 3.6;
  switch (fault) {
    case OdometryFault::none: break;
    case OdometryFault::negated: state.speed = -state.speed; break;
    case OdometryFault::map_frame: state.speed *= std::cos(yaw); break;
    case OdometryFault::km_h: state.speed *= km_h_per_m_s; break;
    case OdometryFault::deg_s: state.yaw_rate *= 180.0 / std::numbers::pi; break;
    case OdometryFault::stuck: state = {0.0, 0.0, state.steering_angle}; break;
  }
  return state;
}

}  // namespace

Sensors::Sensors(const SensorParams& params, std::uint64_t seed) : params_(params), rng_(seed, 2), imu_rng_(seed, 3) {
  validate(params, "sensors");
}

void Sensors::change(const SensorParams& params) {
  validate(params, "sensors");
  params_ = params;
}

void Sensors::record(double time, const SensedMotion& motion) noexcept {
  const Sample& last = samples_[(count_ + samples_.size() - 1) % samples_.size()];
  const double dt = count_ > 0 ? time - last.time : 0.0;
  const Point2 acceleration = motion.acceleration;
  Sample next{time, motion, {last.impulse.x + dt * acceleration.x, last.impulse.y + dt * acceleration.y}};
  next.motion.state.speed *= (1.0 + params_.wheel_slip * motion.drive) * rolling(-motion.drive, dt);
  samples_[count_ % samples_.size()] = next;
  ++count_;
}

// Wheel speed as a share of the car's speed: 0 while the wheels are locked.
double Sensors::rolling(double braking, double dt) noexcept {
  if (params_.wheel_lock_deceleration <= 0.0) return rolling_ = 1.0;
  const double target = braking > params_.wheel_lock_deceleration ? 0.0 : 1.0;
  return rolling_ += (target - rolling_) * (1.0 - std::exp(-dt / params_.wheel_lock_time));
}

const Sensors::Sample& Sensors::sample_of(double time) const noexcept {
  const std::size_t kept = std::min(count_, samples_.size());
  std::size_t age = 1;
  while (age < kept && samples_[(count_ - age) % samples_.size()].time > time - params_.latency + 1e-9) ++age;
  return samples_[(count_ - age) % samples_.size()];
}

SensorReading Sensors::read(double time) noexcept {
  if (count_ == 0) return {};
  const Sample& then = sample_of(time);
  const VehicleState state = measure(then.motion);
  const Point2 acceleration = measure_acceleration(then);
  read_ = then;
  return {state.speed, state.yaw_rate, state.steering_angle, acceleration.x, acceleration.y};
}

VehicleState Sensors::measure(const SensedMotion& motion) noexcept {
  const VehicleState& truth = motion.state;
  const VehicleState measured{
      truth.speed * (1.0 + params_.speed_scale_error) + params_.speed_noise * rng_.gaussian(),
      truth.yaw_rate + params_.yaw_rate_bias + params_.yaw_rate_noise * rng_.gaussian(),
      truth.steering_angle + params_.steering_offset + params_.steering_noise * rng_.gaussian()};
  return misread(measured, motion.yaw, static_cast<OdometryFault>(params_.odometry_fault));
}

Point2 Sensors::measure_acceleration(const Sample& sample) noexcept {
  const double span = sample.time - read_.time;
  const Point2 mean =
      span > 0.0 ? Point2{(sample.impulse.x - read_.impulse.x) / span, (sample.impulse.y - read_.impulse.y) / span}
                 : sample.motion.acceleration;
  const double vibration = sample.motion.state.speed == 0.0 ? 0.0 : params_.vibration;
  const double noise = std::hypot(params_.acceleration_noise, vibration);
  const double x = mean.x + params_.acceleration_x_bias + noise * imu_rng_.gaussian();
  return {x, mean.y + params_.acceleration_y_bias + noise * imu_rng_.gaussian()};
}

}  // namespace firstlap::sim
