#include "firstlap/estimation/state_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap {
namespace {

constexpr int patience = 4;       // maximum number of consecutive rejected measurements
constexpr double max_step = 0.5;  // [s] longer gaps are predicted over this time
constexpr double max_speed = 100.0, max_rate = 100.0, max_bias = 2.0;

double square(double value) noexcept { return value * value; }

}  // namespace

StateEstimate::StateEstimate(const StateEstimateParams& params, const CarGeometry& car) : params_(params), car_(car) {
  validate(params, "state_estimate");
  validate(car, "car");
  reset();
}

void StateEstimate::reset() noexcept {
  x_ = {};
  p_ = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 0.01}}};
  steering_ = params_.steering_offset;
  speed_doubted_ = rate_doubted_ = 0;
}

void StateEstimate::predict(const DriveCommand& command, double dt) noexcept {
  if (!std::isfinite(dt) || dt <= 0.0) return;
  dt = std::min(dt, max_step);
  if (std::isfinite(command.steering_angle)) {
    const double wanted =
        std::clamp(command.steering_angle, -car_.steering_limit, car_.steering_limit) + params_.steering_offset;
    const double share = params_.servo_time > 0.0 ? 1.0 - std::exp(-dt / params_.servo_time) : 1.0;
    const double most = car_.steering_rate * dt;
    steering_ += std::clamp(share * (wanted - steering_), -most, most);
  }
  p_[0][0] += square(params_.acceleration_sigma * dt);
  p_[1][1] += square(params_.yaw_acceleration_sigma * dt);
  p_[2][2] += square(params_.bias_drift) * dt;
  follow_model();
}

// Pseudo-measurement of the yaw rate from speed and steering angle; zero at standstill.
void StateEstimate::follow_model() noexcept {
  int never = 0;
  const double v = x_[0];
  if (std::abs(v) < params_.standstill_speed) {
    correct({0.0, 1.0, 0.0}, -x_[1], square(0.01), false, never);
    return;
  }
  const double per_speed = std::tan(steering_) / (car_.wheelbase * (1.0 + std::max(params_.understeer * v * v, -0.5)));
  const double expected = v * per_speed;
  const double sigma = params_.model_sigma + params_.slip_sigma * std::abs(v * expected);
  correct({-per_speed, 1.0, 0.0}, expected - x_[1], square(sigma), false, never);
}

void StateEstimate::measure_speed(double speed) noexcept {
  if (!std::isfinite(speed)) return;
  correct({1.0, 0.0, 0.0}, params_.speed_scale * std::clamp(speed, -max_speed, max_speed) - x_[0],
          square(params_.speed_sigma), true, speed_doubted_);
}

void StateEstimate::measure_yaw_rate(double yaw_rate) noexcept {
  if (!std::isfinite(yaw_rate)) return;
  correct({0.0, 1.0, 1.0}, std::clamp(yaw_rate, -max_rate, max_rate) - x_[1] - x_[2], square(params_.yaw_rate_sigma),
          true, rate_doubted_);
}

void StateEstimate::measure_steering(double steering_angle) noexcept {
  if (!std::isfinite(steering_angle)) return;
  const double measured =
      std::clamp(steering_angle, -car_.steering_limit, car_.steering_limit) + params_.steering_offset;
  steering_ += square(params_.servo_sigma) / (square(params_.servo_sigma) + square(params_.steering_sigma)) *
               (measured - steering_);
}

// Scalar Kalman update with the row `row` of the measurement matrix. Outliers are rejected, but at most `patience` in a
// row.
void StateEstimate::correct(const Vector& row, double innovation, double variance, bool gated, int& doubted) noexcept {
  Vector column{};  // P h
  double total = variance;
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t j = 0; j < n_; ++j) column[i] += p_[i][j] * row[j];
  }
  for (std::size_t i = 0; i < n_; ++i) total += row[i] * column[i];
  if (gated && square(innovation) > square(params_.gate) * total && doubted < patience) {
    ++doubted;
    return;
  }
  doubted = 0;
  for (std::size_t i = 0; i < n_; ++i) x_[i] += column[i] / total * innovation;
  for (std::size_t i = 0; i < n_; ++i) {
    for (std::size_t j = 0; j < n_; ++j) p_[i][j] -= column[i] * column[j] / total;
    p_[i][i] = std::clamp(p_[i][i], 1e-9, 1e4);
  }
  x_[0] = std::clamp(x_[0], -max_speed, max_speed);
  x_[1] = std::clamp(x_[1], -max_rate, max_rate);
  x_[2] = std::clamp(x_[2], -max_bias, max_bias);
}

}  // namespace firstlap
