// The paper's Estimation layer: an extended Kalman filter fuses wheel speed, gyro, accelerometer, steering angle and
// command into the state that drivers take. docs/estimation.md has its equations. No allocation, bounded work, finite
// for any input.
#pragma once

#include <tuple>

#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/common/delay_line.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/estimation/gaussian.hpp"
#include "firstlap/estimation/state_estimate_params.hpp"

namespace firstlap {

// All estimated quantities. Drivers take `state`.
struct MotionEstimate {
  VehicleState state{};
  double lateral_speed = 0.0;
  double yaw_rate_bias = 0.0;
  double acceleration_x_bias = 0.0;
  double acceleration_y_bias = 0.0;
  double wheel_slip = 0.0;
  bool wheels_rejected = false;

  static constexpr auto columns() {
    using C = MotionEstimate;
    return std::tuple{
        Part{&C::state},
        Column{"lateral_speed", &C::lateral_speed, "m/s", "of base_link, left positive"},
        Column{"yaw_rate_bias", &C::yaw_rate_bias, "rad/s", "of the gyro"},
        Column{"acceleration_x_bias", &C::acceleration_x_bias, "m/s^2", "of the accelerometer, forward"},
        Column{"acceleration_y_bias", &C::acceleration_y_bias, "m/s^2", "of the accelerometer, to the left"},
        Column{"wheel_slip", &C::wheel_slip, "s^2/m", "slip of the wheels per acceleration"},
        Column{"wheels_rejected", &C::wheels_rejected, "",
               "the wheel speed contradicts the accelerometer, because the wheels lock or spin"},
    };
  }
};

class StateEstimate {
 public:
  enum Index : std::size_t { speed, lateral, yaw_rate, gyro_bias, x_bias, y_bias, slip, size };
  using Belief = Gaussian<size>;

  // Throws std::invalid_argument with field, value and allowed range.
  explicit StateEstimate(const StateEstimateParams& params, const CarModel& car = {});

  // Updates with the measurements `dt` [s] after the last update; `command` is the command in effect from now on.
  // Values of `reading` that are not finite count as not measured, those of `command` as not known (such as while a
  // person drives), and a `dt` that is not finite or not positive as 0.
  void update(const SensorReading& reading, const DriveCommand& command, double dt) noexcept;

  [[nodiscard]] MotionEstimate estimate() const noexcept;
  [[nodiscard]] const Belief& belief() const noexcept { return belief_; }
  // Keeps the estimate. Throws as the constructor does; then nothing changes.
  void set_params(const StateEstimateParams& params, const CarModel& car);
  void reset() noexcept;

 private:
  struct Acceleration {
    double forward = 0.0, left = 0.0;  // [m/s^2] measured
    double age = 0.0;                  // [s] since the measurement
  };

  // `row`: of the measurement matrix. `innovation`: measured minus predicted.
  struct Measurement {
    Belief::Vector row{};
    double innovation = 0.0, variance = 0.0;
  };

  struct Rejection {
    Index about;          // the measured state
    double limit;         // [s] maximum time for which it is rejected
    bool active = false;  // the last reading was rejected
    double since = 0.0;   // [s] time of the first one
  };

  void queue_command(const DriveCommand& command) noexcept;
  void predict_servo(double dt) noexcept;
  void add_drift(double dt) noexcept;
  void measure_acceleration(const SensorReading& reading, double dt) noexcept;
  void measure_yaw_rate(double measured) noexcept;
  void measure_steering(double measured) noexcept;
  void measure_wheels(double measured) noexcept;
  void predict_velocity(double yaw_rate_before, double dt) noexcept;
  void predict_by_acceleration(double yaw_rate_before, double dt) noexcept;
  void predict_by_command(double dt) noexcept;
  void follow_steering(double dt) noexcept;
  void follow_tires(double dt) noexcept;
  void correct_standstill() noexcept;
  void bound() noexcept;
  [[nodiscard]] bool has_acceleration() const noexcept;
  [[nodiscard]] bool knows_steering() const noexcept;
  void correct_gated(const Measurement& measurement, Rejection& rejection) noexcept;

  StateEstimateParams params_;
  CarModel car_;
  Belief belief_{};
  DelayLine steering_line_{}, speed_line_{};
  DriveCommand queued_{};  // the last one in both lines
  Acceleration acceleration_{}, previous_acceleration_{};
  double time_ = 0.0;            // [s] since the reset
  double steering_ = 0.0;        // [rad]
  double steering_known_ = 0.0;  // [s] time at which it was last measured or predicted from a command
  Rejection wheels_, gyro_;
};

}  // namespace firstlap
