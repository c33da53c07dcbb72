// The parameters of the state estimate, with default, unit, range and meaning.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

// The assumptions of the state estimate about the sensors and the car.
struct StateEstimateParams {
  bool enabled = false;
  double imu_x = 0.171;
  double speed_sigma = 0.05;
  double speed_scale = 1.0;
  double yaw_rate_sigma = 0.02;
  double steering_sigma = 0.01;
  double steering_offset = 0.0;
  double acceleration_sigma = 0.5;
  double command_sigma = 2.0;
  double yaw_acceleration_sigma = 6.0;
  double yaw_rate_bias_sigma = 0.017;
  double yaw_rate_bias_drift = 0.001;
  double acceleration_bias_sigma = 0.4;
  double acceleration_bias_drift = 0.01;
  double wheel_slip_sigma = 0.006;
  double wheel_slip_drift = 0.003;
  double servo_sigma = 0.02;
  double understeer = 0.005;
  double model_sigma = 0.05;
  double model_acceleration_sigma = 0.15;
  double side_slip = 0.015;
  double side_slip_sigma = 0.03;
  double side_slip_share = 0.3;
  double model_time = 0.2;
  double standstill_speed = 0.1;
  double gate = 4.0;
  double rejection_time = 1.5;

  bool operator==(const StateEstimateParams&) const = default;

  static constexpr auto fields() {
    using P = StateEstimateParams;
    return std::tuple{
        Field{"enabled", &P::enabled, "", 0.0, 1.0, "drivers get the state estimate instead of the measured state"},
        Field{"imu_x", &P::imu_x, "m", -0.5, 1.0, "IMU position ahead of the rear axle"},
        Field{"speed_sigma", &P::speed_sigma, "m/s", 0.001, 5.0, "noise of the wheel speed"},
        Field{"speed_scale", &P::speed_scale, "", 0.5, 2.0, "true speed per measured wheel speed"},
        Field{"yaw_rate_sigma", &P::yaw_rate_sigma, "rad/s", 0.001, 5.0, "noise of the gyro"},
        Field{"steering_sigma", &P::steering_sigma, "rad", 0.0001, 0.5, "noise of the measured steering angle"},
        Field{"steering_offset", &P::steering_offset, "rad", -0.3, 0.3, "steering angle at servo position 0"},
        Field{"acceleration_sigma", &P::acceleration_sigma, "m/s^2", 0.01, 50.0,
              "noise of the accelerometer, including vibration"},
        Field{"command_sigma", &P::command_sigma, "m/s^2", 0.01, 50.0,
              "error of the acceleration predicted from the command, without an accelerometer"},
        Field{"yaw_acceleration_sigma", &P::yaw_acceleration_sigma, "rad/s^2", 0.01, 200.0,
              "yaw acceleration between measurements, standard deviation"},
        Field{"yaw_rate_bias_sigma", &P::yaw_rate_bias_sigma, "rad/s", 0.0, 1.0,
              "gyro bias at power-on, standard deviation"},
        Field{"yaw_rate_bias_drift", &P::yaw_rate_bias_drift, "rad/s/sqrt(s)", 0.0, 0.5,
              "random walk of the gyro bias"},
        Field{"acceleration_bias_sigma", &P::acceleration_bias_sigma, "m/s^2", 0.0, 5.0,
              "bias of each axis of the accelerometer at power-on, standard deviation"},
        Field{"acceleration_bias_drift", &P::acceleration_bias_drift, "m/s^2/sqrt(s)", 0.0, 5.0,
              "random walk of the accelerometer bias"},
        Field{"wheel_slip_sigma", &P::wheel_slip_sigma, "s^2/m", 0.0, 0.2,
              "wheel slip per acceleration before the first measurement, standard deviation"},
        Field{"wheel_slip_drift", &P::wheel_slip_drift, "s^2/m/sqrt(s)", 0.0, 0.1, "random walk of the wheel slip"},
        Field{"servo_sigma", &P::servo_sigma, "rad", 0.0001, 0.5, "error of the servo model"},
        Field{"understeer", &P::understeer, "s^2/m^2", -0.1, 0.5, "the yaw rate is divided by 1 + this v^2"},
        Field{"model_sigma", &P::model_sigma, "rad/s", 0.001, 10.0,
              "error of the yaw rate predicted from speed and steering angle"},
        Field{"model_acceleration_sigma", &P::model_acceleration_sigma, "s/m", 0.0, 5.0,
              "increase of that error per lateral acceleration"},
        Field{"side_slip", &P::side_slip, "s^2/m", 0.0, 0.2, "slip angle of the rear axle per lateral acceleration"},
        Field{"side_slip_sigma", &P::side_slip_sigma, "m/s", 0.001, 5.0,
              "error of the lateral speed predicted from the rear axle's slip"},
        Field{"side_slip_share", &P::side_slip_share, "", 0.0, 5.0, "increase of that error, as a share of the speed"},
        Field{"model_time", &P::model_time, "s", 0.001, 10.0, "correlation time of the errors of both predictions"},
        Field{"standstill_speed", &P::standstill_speed, "m/s", 0.0, 1.0,
              "below this speed the car is assumed to stand still, so that the gyro measures its bias"},
        Field{"gate", &P::gate, "", 1.0, 100.0,
              "innovations above this many sigma are rejected, such as the speed of wheels that lock or spin"},
        Field{"rejection_time", &P::rejection_time, "s", 0.0, 60.0,
              "maximum time for which the wheel speed is rejected"},
    };
  }
};

}  // namespace firstlap
