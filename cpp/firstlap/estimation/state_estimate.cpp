#include "firstlap/estimation/state_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firstlap {
namespace {

constexpr double max_step = 0.2;                 // [s] longer gaps are predicted over this time
constexpr double acceleration_hold = 0.1;        // [s] for which a measured acceleration is used
constexpr double steering_hold = 0.2;            // [s] for which a steering angle is used
constexpr double yaw_rate_rejection_time = 0.1;  // [s] maximum time for which the gyro is rejected
constexpr double initial_speed_sigma = 5.0;      // [m/s] before the first measurement
constexpr double initial_yaw_rate_sigma = 5.0;   // [rad/s] before the first measurement
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double standstill_sigma = 0.01;   // [rad/s], [m/s] of a car at standstill
constexpr double max_speed = 50.0;          // [m/s]
constexpr double max_yaw_rate = 35.0;       // [rad/s] range of a gyro
constexpr double max_acceleration = 160.0;  // [m/s^2] range of an accelerometer
constexpr double max_gyro_bias = 2.0, max_acceleration_bias = 10.0, max_slip = 0.2;
constexpr double min_variance = 1e-9, max_variance = 1e4;
constexpr double min_understeer = -0.5;  // of understeer v^2: the yaw rate at most doubles

double square(double value) noexcept { return value * value; }

// `value` where it is well above the noise `sigma`, almost 0 where it may be noise, so that noise causes no slip.
double shrink_noise(double value, double sigma) noexcept {
  return value * square(value) / (square(value) + square(sigma));
}

// Not known if it is not finite.
double bounded(double value, double limit) noexcept {
  return std::isfinite(value) ? std::clamp(value, -limit, limit) : unknown;
}

// Unknown values are the same.
bool is_same(double a, double b) noexcept { return a == b || (!std::isfinite(a) && !std::isfinite(b)); }

bool is_finite(const StateEstimate::Belief& belief) noexcept {
  double zero = 0.0;
  for (std::size_t i = 0; i < StateEstimate::size; ++i) {
    zero += 0.0 * belief.mean[i];
    for (const double each : belief.covariance[i]) zero += 0.0 * each;
  }
  return zero == 0.0;
}

}  // namespace

StateEstimate::StateEstimate(const StateEstimateParams& params, const CarModel& car)
    : params_(params), car_(car), wheels_{speed, params.rejection_time}, gyro_{yaw_rate, yaw_rate_rejection_time} {
  validate(params, "state_estimate");
  validate(car, "car");
  reset();
}

void StateEstimate::set_params(const StateEstimateParams& params, const CarModel& car) {
  validate(params, "state_estimate");
  validate(car, "car");
  params_ = params;
  car_ = car;
  wheels_.limit = params.rejection_time;
}

void StateEstimate::reset() noexcept {
  belief_ = {};
  auto& p = belief_.covariance;
  p[speed][speed] = square(initial_speed_sigma);
  p[lateral][lateral] = square(params_.side_slip_sigma);
  p[yaw_rate][yaw_rate] = square(initial_yaw_rate_sigma);
  p[gyro_bias][gyro_bias] = square(params_.yaw_rate_bias_sigma);
  p[x_bias][x_bias] = p[y_bias][y_bias] = square(params_.acceleration_bias_sigma);
  p[slip][slip] = square(params_.wheel_slip_sigma);
  steering_line_.reset(unknown);
  speed_line_.reset(unknown);
  queued_ = {unknown, unknown};
  acceleration_ = previous_acceleration_ = {.age = std::numeric_limits<double>::infinity()};
  time_ = 0.0;
  steering_ = params_.steering_offset;
  steering_known_ = -std::numeric_limits<double>::infinity();
  wheels_.active = gyro_.active = false;
}

// Predicts with the command, gyro and accelerometer; then corrects with the measured steering angle and wheel speed,
// and with the models of steering and tires.
void StateEstimate::update(const SensorReading& reading, const DriveCommand& commanded, double dt) noexcept {
  dt = std::isfinite(dt) && dt > 0.0 ? std::min(dt, max_step) : 0.0;
  const double yaw_rate_before = belief_.mean[yaw_rate];
  time_ += dt;
  queue_command(commanded);
  predict_servo(dt);
  add_drift(dt);
  measure_acceleration(reading, dt);
  measure_yaw_rate(reading.yaw_rate);
  predict_velocity(yaw_rate_before, dt);
  measure_steering(reading.steering_angle);
  measure_wheels(reading.wheel_speed);
  follow_steering(dt);
  follow_tires(dt);
  bound();
}

MotionEstimate StateEstimate::estimate() const noexcept {
  const auto& x = belief_.mean;
  return {.state = {x[speed], x[yaw_rate], steering_},
          .lateral_speed = x[lateral],
          .yaw_rate_bias = x[gyro_bias],
          .acceleration_x_bias = x[x_bias],
          .acceleration_y_bias = x[y_bias],
          .wheel_slip = x[slip],
          .wheels_rejected = wheels_.active};
}

// A change of the command takes effect after the car's delays.
void StateEstimate::queue_command(const DriveCommand& commanded) noexcept {
  const double steering = bounded(commanded.steering_angle, car_.steering_limit);
  if (!is_same(steering, queued_.steering_angle))
    steering_line_.push(time_ + car_.steering_delay, steering + params_.steering_offset);
  const double wanted = bounded(commanded.speed, max_speed);
  if (!is_same(wanted, queued_.speed)) speed_line_.push(time_ + car_.speed_delay, wanted);
  queued_ = {wanted, steering};
}

// Without a known command the servo is assumed to stay where it is.
void StateEstimate::predict_servo(double dt) noexcept {
  const double target = steering_line_.at(time_);
  if (!std::isfinite(target)) return;
  const double share = 1.0 - std::exp(-dt / car_.servo_time_constant);
  const double limit = car_.steering_rate * dt;
  steering_ += std::clamp(share * (target - steering_), -limit, limit);
  steering_known_ = time_;
}

bool StateEstimate::knows_steering() const noexcept { return time_ - steering_known_ <= steering_hold; }

// Process noise of the states without a motion model.
void StateEstimate::add_drift(double dt) noexcept {
  Belief::Vector noise{};
  noise[yaw_rate] = square(params_.yaw_acceleration_sigma * dt);
  noise[gyro_bias] = square(params_.yaw_rate_bias_drift) * dt;
  noise[x_bias] = noise[y_bias] = square(params_.acceleration_bias_drift) * dt;
  noise[slip] = square(params_.wheel_slip_drift) * dt;
  for (std::size_t i = 0; i < size; ++i) belief_.covariance[i][i] += noise[i];
}

void StateEstimate::measure_acceleration(const SensorReading& reading, double dt) noexcept {
  acceleration_.age += dt;
  if (!std::isfinite(reading.acceleration_x) || !std::isfinite(reading.acceleration_y)) return;
  previous_acceleration_ = acceleration_;
  acceleration_ = {std::clamp(reading.acceleration_x, -max_acceleration, max_acceleration),
                   std::clamp(reading.acceleration_y, -max_acceleration, max_acceleration), 0.0};
}

bool StateEstimate::has_acceleration() const noexcept { return acceleration_.age <= acceleration_hold; }

void StateEstimate::measure_yaw_rate(double measured) noexcept {
  if (!std::isfinite(measured)) return;
  const auto& x = belief_.mean;
  Belief::Vector row{};
  row[yaw_rate] = row[gyro_bias] = 1.0;
  const double innovation = std::clamp(measured, -max_yaw_rate, max_yaw_rate) - x[yaw_rate] - x[gyro_bias];
  correct_gated({row, innovation, square(params_.yaw_rate_sigma)}, gyro_);
}

void StateEstimate::predict_velocity(double yaw_rate_before, double dt) noexcept {
  if (has_acceleration()) {
    predict_by_acceleration(yaw_rate_before, dt);
  } else {
    predict_by_command(dt);
  }
}

// v' = f_x - b_x + r u + x_imu r^2,  u' = f_y - b_y - r v - x_imu r': the velocity of base_link from the
// acceleration of an IMU ahead of it. In the Jacobian, the errors of r before and now are the same, so that r' has
// none.
void StateEstimate::predict_by_acceleration(double yaw_rate_before, double dt) noexcept {
  auto& x = belief_.mean;
  const double r = 0.5 * (yaw_rate_before + x[yaw_rate]);
  const double v = x[speed], u = x[lateral];
  x[speed] += dt * (acceleration_.forward - x[x_bias] + r * u + params_.imu_x * r * r);
  x[lateral] += dt * (acceleration_.left - x[y_bias] - r * v) - params_.imu_x * (x[yaw_rate] - yaw_rate_before);
  Belief::Matrix f = Belief::identity();
  f[speed][lateral] = dt * r;
  f[speed][yaw_rate] = dt * (u + 2.0 * params_.imu_x * r);
  f[speed][x_bias] = -dt;
  f[lateral][speed] = -dt * r;
  f[lateral][yaw_rate] = -dt * v;
  f[lateral][y_bias] = -dt;
  Belief::Vector noise{};
  noise[speed] = noise[lateral] = square(params_.acceleration_sigma * dt);
  belief_.propagate(f, noise);
}

// Without an accelerometer: the speed follows its command if it is known, or else changes by any possible acceleration;
// and the tire model alone gives the lateral speed.
void StateEstimate::predict_by_command(double dt) noexcept {
  const double target = speed_line_.at(time_);
  const double limit = car_.brake_max * dt;
  Belief::Vector noise{};
  noise[speed] = noise[lateral] = square(params_.command_sigma * dt);
  if (std::isfinite(target)) {
    const double wanted = (1.0 - std::exp(-car_.speed_gain * dt)) * (target - belief_.mean[speed]);
    belief_.mean[speed] += std::clamp(wanted, -limit, limit);
  } else {
    noise[speed] = square(limit);
  }
  belief_.propagate(Belief::identity(), noise);
}

void StateEstimate::measure_steering(double measured) noexcept {
  if (!std::isfinite(measured)) return;
  const double angle = std::clamp(measured, -car_.steering_limit, car_.steering_limit) + params_.steering_offset;
  const double gain = square(params_.servo_sigma) / (square(params_.servo_sigma) + square(params_.steering_sigma));
  steering_ += gain * (angle - steering_);
  steering_known_ = time_;
}

// Pseudo-measurement r = v tan(delta) / (L (1 + K v^2)). Its errors are correlated: all readings within model_time
// count as one.
void StateEstimate::follow_steering(double dt) noexcept {
  const double v = belief_.mean[speed];
  if (std::abs(v) < params_.standstill_speed) return correct_standstill();
  if (dt <= 0.0 || !knows_steering()) return;
  const double reduced = 1.0 + std::max(params_.understeer * v * v, min_understeer);
  const double per_speed = std::tan(steering_) / (car_.wheelbase * reduced);
  const double sigma = params_.model_sigma + params_.model_acceleration_sigma * std::abs(v * v * per_speed);
  Belief::Vector row{};
  row[speed] = -per_speed * (2.0 / reduced - 1.0);
  row[yaw_rate] = 1.0;
  belief_.correct(row, v * per_speed - belief_.mean[yaw_rate], square(sigma) * std::max(1.0, params_.model_time / dt));
}

// If the gyro turns although the wheels stand still, the car is carried.
void StateEstimate::correct_standstill() noexcept {
  Belief::Vector turning{};
  turning[yaw_rate] = 1.0;
  const double variance = belief_.innovation_variance(turning, square(standstill_sigma));
  if (square(belief_.mean[yaw_rate]) > square(params_.gate) * variance) return;
  for (const Index still : {yaw_rate, lateral}) {
    Belief::Vector row{};
    row[still] = 1.0;
    belief_.correct(row, -belief_.mean[still], square(standstill_sigma));
  }
}

// Pseudo-measurement u = -c |v| (v r): the slip angle of the rear axle is proportional to the lateral acceleration.
void StateEstimate::follow_tires(double dt) noexcept {
  if (dt <= 0.0) return;
  const double v = belief_.mean[speed], r = belief_.mean[yaw_rate];
  const double expected = -params_.side_slip * std::abs(v) * v * r;
  const double sigma = params_.side_slip_sigma + params_.side_slip_share * std::abs(expected);
  Belief::Vector row{};
  row[lateral] = 1.0;
  row[speed] = 2.0 * params_.side_slip * std::abs(v) * r;
  row[yaw_rate] = params_.side_slip * std::abs(v) * v;
  belief_.correct(row, expected - belief_.mean[lateral], square(sigma) * std::max(1.0, params_.model_time / dt));
}

// w = v (1 + k f), with the force per mass f that drives the wheels, f_x - b_x at the center of gravity, which is about
// in the middle of the wheelbase. It is measured with noise, and may change within the time of a reading.
void StateEstimate::measure_wheels(double measured) noexcept {
  if (!std::isfinite(measured)) return;
  const auto& x = belief_.mean;
  const double v = x[speed];
  const double centripetal = (params_.imu_x - 0.5 * car_.wheelbase) * square(x[yaw_rate]);
  const double force = has_acceleration()
                           ? shrink_noise(acceleration_.forward - x[x_bias] + centripetal, params_.acceleration_sigma)
                           : 0.0;
  const double change = has_acceleration() && previous_acceleration_.age <= acceleration_hold
                            ? acceleration_.forward - previous_acceleration_.forward
                            : 0.0;
  Belief::Vector row{};
  row[speed] = 1.0 + x[slip] * force;
  row[x_bias] = has_acceleration() ? -x[slip] * v : 0.0;
  row[slip] = v * force;
  const double wheels = params_.speed_scale * std::clamp(measured, -max_speed, max_speed);
  const double slip_square = square(x[slip]) + belief_.covariance[slip][slip];
  const double force_variance = square(params_.acceleration_sigma) + square(change);
  const double variance = square(params_.speed_sigma) + slip_square * square(v) * force_variance;
  correct_gated({row, wheels - v * row[speed], variance}, wheels_);
}

// Outliers are rejected for up to the limit, however many readings that are; after that, the variance of the measured
// state is increased.
void StateEstimate::correct_gated(const Measurement& measurement, Rejection& rejection) noexcept {
  const auto& [row, innovation, variance] = measurement;
  const bool outlier = square(innovation) > square(params_.gate) * belief_.innovation_variance(row, variance);
  if (outlier && !rejection.active) rejection.since = time_;
  rejection.active = outlier && time_ - rejection.since < rejection.limit;
  if (rejection.active) return;
  if (outlier) belief_.covariance[rejection.about][rejection.about] += square(innovation);
  belief_.correct(row, innovation, variance);
}

// Limits mean and variance, and resets an estimate that is not finite.
void StateEstimate::bound() noexcept {
  if (!is_finite(belief_)) return reset();
  constexpr Belief::Vector limit{
      max_speed, max_speed, max_yaw_rate, max_gyro_bias, max_acceleration_bias, max_acceleration_bias, max_slip};
  for (std::size_t i = 0; i < size; ++i) {
    belief_.mean[i] = std::clamp(belief_.mean[i], -limit[i], limit[i]);
    double& variance = belief_.covariance[i][i];
    variance = std::max(variance, min_variance);
    if (variance > max_variance) belief_.scale(i, std::sqrt(max_variance / variance));
  }
}

}  // namespace firstlap
