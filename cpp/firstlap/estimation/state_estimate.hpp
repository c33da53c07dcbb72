// The paper's Estimation layer, for cars with poor odometry: an extended Kalman filter of speed, yaw rate and gyro bias
// fuses wheel speed, gyro and steering angle into the state that drivers take. The servo is modeled, and corrected
// where its angle is measured. No allocation, bounded work, finite for any input.
#pragma once

#include <array>
#include <tuple>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap {

struct StateEstimateParams {
  double speed_sigma = 0.1;
  double yaw_rate_sigma = 0.05;
  double steering_sigma = 0.01;
  double acceleration_sigma = 2.0;
  double yaw_acceleration_sigma = 8.0;
  double bias_drift = 0.002;
  double model_sigma = 0.1;
  double slip_sigma = 0.08;
  double understeer = 0.01;
  double servo_time = 0.04;
  double servo_sigma = 0.02;
  double steering_offset = 0.0;
  double speed_scale = 1.0;
  double standstill_speed = 0.1;
  double gate = 5.0;

  static constexpr auto fields() {
    using P = StateEstimateParams;
    return std::tuple{
        Field{"speed_sigma", &P::speed_sigma, "m/s", 0.001, 5.0, "noise of the wheel speed"},
        Field{"yaw_rate_sigma", &P::yaw_rate_sigma, "rad/s", 0.001, 5.0, "noise of the gyro"},
        Field{"steering_sigma", &P::steering_sigma, "rad", 0.0001, 0.5, "noise of the measured steering angle"},
        Field{"acceleration_sigma", &P::acceleration_sigma, "m/s^2", 0.01, 50.0,
              "acceleration between measurements, standard deviation"},
        Field{"yaw_acceleration_sigma", &P::yaw_acceleration_sigma, "rad/s^2", 0.01, 200.0,
              "yaw acceleration between measurements, standard deviation"},
        Field{"bias_drift", &P::bias_drift, "rad/s", 0.0, 0.5, "drift of the gyro bias per second"},
        Field{"model_sigma", &P::model_sigma, "rad/s", 0.001, 10.0,
              "error of the yaw rate predicted from speed and steering angle"},
        Field{"slip_sigma", &P::slip_sigma, "s/m", 0.0, 5.0, "increase of that error per lateral acceleration"},
        Field{"understeer", &P::understeer, "s^2/m^2", -0.1, 0.5, "the yaw rate is divided by 1 + this v^2"},
        Field{"servo_time", &P::servo_time, "s", 0.0, 1.0, "first-order lag of the servo"},
        Field{"servo_sigma", &P::servo_sigma, "rad", 0.0001, 0.5, "error of the servo model"},
        Field{"steering_offset", &P::steering_offset, "rad", -0.3, 0.3, "steering angle at servo position 0"},
        Field{"speed_scale", &P::speed_scale, "", 0.5, 2.0, "true speed per measured speed"},
        Field{"standstill_speed", &P::standstill_speed, "m/s", 0.0, 1.0,
              "below this speed the car stands still, and the gyro measures its bias"},
        Field{"gate", &P::gate, "", 1.0, 100.0, "measurements this many sigma off are rejected at first"},
    };
  }
};

class StateEstimate {
 public:
  // Throws std::invalid_argument with field, value and allowed range.
  explicit StateEstimate(const StateEstimateParams& params, const CarGeometry& car = {});

  // Predicts by `dt` [s]; the servo follows `command`. Does nothing if `dt` is not finite or not positive.
  void predict(const DriveCommand& command, double dt) noexcept;

  // Measurements at the predicted time. Ignored if not finite.
  void measure_speed(double speed) noexcept;              // [m/s] wheel speed
  void measure_yaw_rate(double yaw_rate) noexcept;        // [rad/s] gyro
  void measure_steering(double steering_angle) noexcept;  // [rad]

  VehicleState state() const noexcept { return {x_[0], x_[1], steering_}; }
  double yaw_rate_bias() const noexcept { return x_[2]; }  // [rad/s]
  void reset() noexcept;

 private:
  static constexpr std::size_t n_ = 3;  // speed, yaw rate, bias
  using Vector = std::array<double, n_>;

  void correct(const Vector& row, double innovation, double variance, bool gated, int& doubted) noexcept;
  void follow_model() noexcept;

  StateEstimateParams params_;
  CarGeometry car_;
  Vector x_{};
  std::array<Vector, n_> p_{};  // covariance
  double steering_ = 0.0;       // [rad]
  int speed_doubted_ = 0, rate_doubted_ = 0;
};

}  // namespace firstlap
