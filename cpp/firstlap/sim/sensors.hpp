// Measurements of the car's own state: wheel speed, yaw rate, acceleration and steering angle, with errors; and the
// LiDAR's mounting errors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "firstlap/common/field.hpp"
#include "firstlap/common/rng.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap::sim {

// Typical faults of odometry nodes.
enum class OdometryFault : int {
  none = 0,
  negated = 1,    // forward speed is negative
  map_frame = 2,  // speed along the map's x axis
  km_h = 3,
  deg_s = 4,
  stuck = 5,  // all values stuck at 0
};

struct SensorParams {
  double speed_noise = 0.03;
  double speed_scale_error = 0.0;
  double yaw_rate_noise = 0.02;
  double yaw_rate_bias = 0.0;
  double steering_noise = 0.003;
  double steering_offset = 0.0;
  double imu_x = 0.171;
  double acceleration_noise = 0.018;
  double vibration = 0.3;
  double acceleration_x_bias = 0.0;
  double acceleration_y_bias = 0.0;
  double wheel_slip = 0.0;
  double wheel_lock_deceleration = 0.0;
  double wheel_lock_time = 0.03;
  double latency = 0.0;
  int odometry_fault = 0;
  double laser_x_error = 0.0;
  double laser_y_error = 0.0;
  double laser_yaw_error = 0.0;

  static constexpr auto fields() {
    using P = SensorParams;
    return std::tuple{
        Field{"speed_noise", &P::speed_noise, "m/s", 0.0, 2.0, "standard deviation of the speed"},
        Field{"speed_scale_error", &P::speed_scale_error, "", -0.5, 0.5,
              "the measured speed is 1 + this times the true speed"},
        Field{"yaw_rate_noise", &P::yaw_rate_noise, "rad/s", 0.0, 2.0, "standard deviation of the yaw rate"},
        Field{"yaw_rate_bias", &P::yaw_rate_bias, "rad/s", -1.0, 1.0, "added to the yaw rate"},
        Field{"steering_noise", &P::steering_noise, "rad", 0.0, 0.5, "standard deviation of the steering angle"},
        Field{"steering_offset", &P::steering_offset, "rad", -0.2, 0.2, "added to the steering angle"},
        Field{"imu_x", &P::imu_x, "m", -0.5, 1.0, "true IMU position ahead of the rear axle"},
        Field{"acceleration_noise", &P::acceleration_noise, "m/s^2", 0.0, 20.0,
              "standard deviation of the acceleration; Bosch BMI160: 1.8 mg"},
        Field{"vibration", &P::vibration, "m/s^2", 0.0, 20.0,
              "standard deviation of the car's vibration in the acceleration, while it moves"},
        Field{"acceleration_x_bias", &P::acceleration_x_bias, "m/s^2", -5.0, 5.0,
              "added to the forward acceleration; Bosch BMI160: up to 40 mg"},
        Field{"acceleration_y_bias", &P::acceleration_y_bias, "m/s^2", -5.0, 5.0,
              "added to the acceleration to the left; Bosch BMI160: up to 40 mg"},
        Field{"wheel_slip", &P::wheel_slip, "s^2/m", 0.0, 0.1,
              "the wheels turn faster than the car by this times its acceleration"},
        Field{"wheel_lock_deceleration", &P::wheel_lock_deceleration, "m/s^2", 0.0, 50.0,
              "the wheels lock while the car brakes harder than this (0: never)"},
        Field{"wheel_lock_time", &P::wheel_lock_time, "s", 0.001, 1.0,
              "time constant of a wheel that locks or spins up again"},
        Field{"latency", &P::latency, "s", 0.0, 0.2, "age of a measurement when the driver receives it"},
        Field{"odometry_fault", &P::odometry_fault, "", 0.0, 5.0,
              "0 none, 1 speed negated, 2 speed in the map frame, 3 km/h, 4 deg/s, 5 stuck at 0"},
        Field{"laser_x_error", &P::laser_x_error, "m", -0.5, 0.5, "LiDAR position error, forward"},
        Field{"laser_y_error", &P::laser_y_error, "m", -0.5, 0.5, "LiDAR position error, left"},
        Field{"laser_yaw_error", &P::laser_yaw_error, "rad", -3.2, 3.2, "LiDAR yaw error, left"},
    };
  }
};

// The true motion. `state` and `yaw` [rad] in the map frame as the car's own electronics measure them; `acceleration`
// [m/s^2] at the IMU, forward and left; `drive` [m/s^2] the forward force of the tires per mass of the car.
struct SensedMotion {
  VehicleState state{};
  double yaw = 0.0;
  Point2 acceleration{};
  double drive = 0.0;
};

class Sensors {
 public:
  // Throws std::invalid_argument for a parameter outside its range.
  Sensors(const SensorParams& params, std::uint64_t seed);

  // Changes the errors from now on. Throws as the constructor does; then nothing changes.
  void change(const SensorParams& params);

  // Records the true motion at `time` [s]. Times must not decrease.
  void record(double time, const SensedMotion& motion) noexcept;

  // Measures the newest recorded motion that is at least `latency` old (if there is none, the oldest), with errors. The
  // acceleration is the mean since the last reading, as the filter of an IMU outputs it.
  SensorReading read(double time) noexcept;

 private:
  struct Sample {
    double time = 0.0;
    SensedMotion motion{};
    Point2 impulse{};  // [m/s] integral of the acceleration
  };

  [[nodiscard]] const Sample& sample_of(double time) const noexcept;
  [[nodiscard]] double rolling(double braking, double dt) noexcept;
  VehicleState measure(const SensedMotion& motion) noexcept;
  Point2 measure_acceleration(const Sample& sample) noexcept;

  SensorParams params_;
  Rng rng_, imu_rng_;
  std::array<Sample, 512> samples_{};
  std::size_t count_ = 0;
  double rolling_ = 1.0;  // wheel speed as a share of the car's speed
  Sample read_{};         // sample of the last reading
};

}  // namespace firstlap::sim
