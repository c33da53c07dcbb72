#include "firstlap/estimation/state_estimate.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>

#include "firstlap/common/rng.hpp"
#include "firstlap/sim/car.hpp"
#include "firstlap/sim/sensors.hpp"
#include "firstlap/sim/vehicle.hpp"
#include "support/allocations.hpp"

namespace firstlap {
namespace {

constexpr double period = 0.025;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double square(double value) { return value * value; }

// RMS errors of the estimated and (raw) of the measured values.
struct Errors {
  double speed = 0.0, yaw_rate = 0.0, lateral = 0.0, locked = 0.0;
  double raw_speed = 0.0, raw_yaw_rate = 0.0, raw_lateral = 0.0, raw_locked = 0.0;
  int count = 0, locks = 0;
};

// Every three seconds: full throttle and hard braking straight ahead, then a bend to either side.
DriveCommand race_command(double time) {
  const double phase = std::fmod(time, 3.0);
  const double side = std::fmod(time, 6.0) < 3.0 ? 1.0 : -1.0;
  if (phase < 1.0) return {5.5, 0.0};
  if (phase < 1.6) return {2.5, 0.0};
  return {2.5, 0.25 * side * std::sin(std::numbers::pi * (phase - 1.6) / 1.4)};
}

// Drives the simulated car as in a race, without standstill, while the estimate is updated with its sensors.
Errors race(const sim::SensorParams& sensed, StateEstimate& estimate, double seconds, bool with_accelerometer = true) {
  sim::Car car = sim::default_car();
  car.sensors = sensed;
  sim::Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.reset({}, 2.0);
  sim::Sensors sensors(sensed, 7);
  const int steps = static_cast<int>(std::ceil(period / car.vehicle.step_dt - 1e-9));
  Errors sum;
  DriveCommand command{2.0, 0.0};
  for (double time = 0.0; time < seconds;) {
    for (int i = 1; i <= steps; ++i) {
      vehicle.step(period / steps);
      sensors.record(time + i * period / steps, sim::sensed(vehicle, car));
    }
    time += period;
    SensorReading reading = sensors.read(time);
    if (!with_accelerometer) reading.acceleration_x = reading.acceleration_y = nan;
    estimate.update(reading, command, period);
    command = race_command(time);
    vehicle.command(command);
    const VehicleState truth = vehicle.state();
    const MotionEstimate found = estimate.estimate();
    sum.speed += square(found.state.speed - truth.speed);
    sum.yaw_rate += square(found.state.yaw_rate - truth.yaw_rate);
    sum.lateral += square(found.lateral_speed - vehicle.lateral_speed());
    sum.raw_speed += square(reading.wheel_speed - truth.speed);
    sum.raw_yaw_rate += square(reading.yaw_rate - truth.yaw_rate);
    sum.raw_lateral += square(vehicle.lateral_speed());
    ++sum.count;
    if (reading.wheel_speed > 0.7 * truth.speed) continue;
    sum.locked += square(found.state.speed - truth.speed);
    sum.raw_locked += square(reading.wheel_speed - truth.speed);
    ++sum.locks;
  }
  for (double* total : {&sum.speed, &sum.yaw_rate, &sum.lateral, &sum.raw_speed, &sum.raw_yaw_rate, &sum.raw_lateral})
    *total = std::sqrt(*total / sum.count);
  for (double* total : {&sum.locked, &sum.raw_locked}) *total = std::sqrt(*total / std::max(sum.locks, 1));
  return sum;
}

constexpr sim::SensorParams biased{.yaw_rate_bias = 0.052, .acceleration_x_bias = 0.39, .acceleration_y_bias = 0.39};

TEST(StateEstimate, is_no_worse_than_clean_sensors) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race({}, estimate, 30.0);
  EXPECT_LE(errors.speed, 0.85 * errors.raw_speed);
  EXPECT_LE(errors.yaw_rate, 1.05 * errors.raw_yaw_rate);  // because it also estimates a bias
}

TEST(StateEstimate, is_twice_as_good_as_wheels_that_slip) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race({.wheel_slip = 0.03}, estimate, 30.0);
  EXPECT_GT(errors.raw_speed, 0.2);
  EXPECT_LT(errors.speed, 0.5 * errors.raw_speed);
  EXPECT_NEAR(estimate.estimate().wheel_slip, 0.03, 0.004);
}

TEST(StateEstimate, is_twice_as_good_as_wheels_that_lock) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race({.wheel_lock_deceleration = 3.0}, estimate, 30.0);
  EXPECT_GT(errors.locks, 50);
  EXPECT_LT(errors.locked, 0.1 * errors.raw_locked);
  EXPECT_LT(errors.speed, 0.1 * errors.raw_speed);
}

TEST(StateEstimate, finds_the_biases_while_driving) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race(biased, estimate, 30.0);
  EXPECT_LE(errors.speed, errors.raw_speed);
  EXPECT_LT(errors.yaw_rate, 0.5 * errors.raw_yaw_rate);
  const MotionEstimate found = estimate.estimate();
  EXPECT_NEAR(found.yaw_rate_bias, 0.052, 0.01);
  EXPECT_NEAR(found.acceleration_x_bias, 0.39, 0.05);
  EXPECT_NEAR(found.acceleration_y_bias, 0.39, 0.1);
}

TEST(StateEstimate, finds_the_side_slip) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race({}, estimate, 30.0);
  EXPECT_LT(errors.lateral, 0.5 * errors.raw_lateral);
}

TEST(StateEstimate, without_an_accelerometer_is_no_worse_than_clean_sensors) {
  StateEstimate estimate{StateEstimateParams{}};
  const Errors errors = race({}, estimate, 30.0, false);
  EXPECT_LE(errors.speed, 1.1 * errors.raw_speed);
}

constexpr SensorReading unmeasured{nan, nan, nan, nan, nan};

// Readings of some sensors only.
SensorReading of_wheels(double speed) {
  SensorReading reading = unmeasured;
  reading.wheel_speed = speed;
  return reading;
}

SensorReading of_imu(double yaw_rate, double forward, double left) {
  SensorReading reading = unmeasured;
  reading.yaw_rate = yaw_rate;
  reading.acceleration_x = forward;
  reading.acceleration_y = left;
  return reading;
}

// Drives straight ahead at constant speed, so that speed and biases converge.
void roll(StateEstimate& estimate, double speed, double seconds = 2.0) {
  for (double time = 0.0; time < seconds; time += period) {
    estimate.update({speed, 0.0, 0.0, 0.0, 0.0}, {speed, 0.0}, period);
  }
}

TEST(StateEstimate, integrates_the_acceleration) {
  StateEstimate estimate{StateEstimateParams{}};
  roll(estimate, 2.0);
  for (int i = 0; i < 40; ++i) estimate.update(of_imu(0.0, 1.5, 0.0), {2.0, 0.0}, period);
  EXPECT_NEAR(estimate.estimate().state.speed, 2.0 + 1.5 * 40 * period, 0.03);
}

// In a steady circle: a_x = -r u - x_imu r^2 and a_y = r v, with the side slip u of the rear axle.
TEST(StateEstimate, compensates_for_an_imu_ahead_of_the_rear_axle) {
  const StateEstimateParams params{
      .imu_x = 0.3, .acceleration_bias_sigma = 0.0, .acceleration_bias_drift = 0.0, .understeer = 0.0};
  StateEstimate estimate{params};
  const double v = 2.0, r = 2.0, u = -params.side_slip * v * v * r;
  const double steering = std::atan(r * CarModel{}.wheelbase / v);
  SensorReading reading = of_imu(r, -r * u - params.imu_x * r * r, r * v);
  reading.steering_angle = steering;
  reading.wheel_speed = v;
  for (int i = 0; i < 80; ++i) estimate.update(reading, {v, steering}, period);
  reading.wheel_speed = nan;
  for (int i = 0; i < 40; ++i) estimate.update(reading, {v, steering}, period);
  EXPECT_NEAR(estimate.estimate().state.speed, v, 0.04);
  EXPECT_NEAR(estimate.estimate().lateral_speed, u, 0.02);
  EXPECT_NEAR(estimate.estimate().state.yaw_rate, r, 0.02);
}

TEST(StateEstimate, follows_the_command_without_an_accelerometer) {
  const CarModel car{};
  StateEstimate estimate{StateEstimateParams{}, car};
  for (int i = 0; i < 400; ++i) estimate.update(unmeasured, {0.5, 0.0}, 0.001);
  EXPECT_NEAR(estimate.estimate().state.speed, 0.5 * (1.0 - std::exp(-car.speed_gain * 0.4)), 1e-6);
  for (int i = 0; i < 100; ++i) estimate.update(unmeasured, {10.0, 0.0}, 0.001);
  EXPECT_NEAR(estimate.estimate().state.speed, 0.5 * (1.0 - std::exp(-car.speed_gain * 0.4)) + 0.1 * car.brake_max,
              1e-6);
}

TEST(StateEstimate, models_delay_lag_and_rate_of_the_servo) {
  CarModel car{};
  car.steering_delay = 0.05;
  car.servo_time_constant = 0.1;
  StateEstimate estimate{{.steering_offset = 0.02}, car};
  for (int i = 0; i < 50; ++i) estimate.update(unmeasured, {1.0, 0.1}, 0.001);
  EXPECT_NEAR(estimate.estimate().state.steering_angle, 0.02, 1e-3);
  for (int i = 0; i < 100; ++i) estimate.update(unmeasured, {1.0, 0.1}, 0.001);
  EXPECT_NEAR(estimate.estimate().state.steering_angle, 0.02 + 0.1 * (1.0 - std::exp(-1.0)), 1e-3);
  for (int i = 0; i < 50; ++i) estimate.update(unmeasured, {1.0, -car.steering_limit}, 0.001);
  const double before = estimate.estimate().state.steering_angle;
  for (int i = 0; i < 10; ++i) estimate.update(unmeasured, {1.0, -car.steering_limit}, 0.001);
  EXPECT_NEAR(estimate.estimate().state.steering_angle, before - 0.01 * car.steering_rate, 1e-9);
}

TEST(StateEstimate, predicts_the_yaw_rate_from_the_steering_angle_without_a_gyro) {
  StateEstimate estimate{{.understeer = 0.02}};
  for (int i = 0; i < 200; ++i) {
    SensorReading reading = of_wheels(2.0);
    reading.steering_angle = 0.2;
    estimate.update(reading, {2.0, 0.2}, period);
  }
  EXPECT_NEAR(estimate.estimate().state.yaw_rate, 2.0 * std::tan(0.2) / (0.33 * (1.0 + 0.02 * 4.0)), 0.02);
  EXPECT_NEAR(estimate.estimate().state.steering_angle, 0.2, 1e-3);
}

TEST(StateEstimate, finds_the_gyro_bias_at_standstill) {
  StateEstimate estimate{StateEstimateParams{}};
  const double slow = 0.5 * StateEstimateParams{}.standstill_speed, turned = 0.3;
  for (int i = 0; i < 80; ++i) estimate.update({slow, 0.1, turned, 0.0, 0.0}, {0.0, turned}, period);
  EXPECT_NEAR(estimate.estimate().yaw_rate_bias, 0.1, 0.01);
  EXPECT_NEAR(estimate.estimate().state.yaw_rate, 0.0, 0.01);
}

TEST(StateEstimate, locked_wheels_are_rejected_until_they_turn_again) {
  StateEstimate estimate{StateEstimateParams{}};
  roll(estimate, 5.0);
  EXPECT_FALSE(estimate.estimate().wheels_rejected);
  for (int i = 1; i <= 20; ++i) estimate.update({0.0, 0.0, 0.0, -4.0, 0.0}, {2.0, 0.0}, period);
  EXPECT_TRUE(estimate.estimate().wheels_rejected);
  EXPECT_NEAR(estimate.estimate().state.speed, 5.0 - 4.0 * 20 * period, 0.05);
  for (int i = 0; i < 4; ++i) estimate.update({3.0, 0.0, 0.0, 0.0, 0.0}, {3.0, 0.0}, period);
  EXPECT_FALSE(estimate.estimate().wheels_rejected);
  EXPECT_NEAR(estimate.estimate().state.speed, 3.0, 0.05);
}

TEST(StateEstimate, wheels_that_contradict_the_accelerometer_for_long_are_used_again) {
  const StateEstimateParams params{.rejection_time = 0.5};
  StateEstimate estimate{params};
  roll(estimate, 2.0);
  const auto measure_wheels = [&](double speed, int times) {
    for (int i = 0; i < times; ++i) estimate.update({speed, 0.0, 0.0, 0.0, 0.0}, {2.0, 0.0}, period);
  };
  measure_wheels(6.0, 19);
  EXPECT_NEAR(estimate.estimate().state.speed, 2.0, 0.05);
  measure_wheels(6.0, 4);
  EXPECT_NEAR(estimate.estimate().state.speed, 6.0, 0.1);
}

// Every sensor in a message of its own, as in a ROS node: `imu_rate` readings of the IMU per one of the wheels, which
// come at 50 Hz. With `equal_stamps`, no time passes between the IMU's last reading and the wheels'.
void roll_in_messages(StateEstimate& estimate, double wheels, double seconds, int per_wheels, bool equal_stamps) {
  const double step = 0.02 / (per_wheels + (equal_stamps ? 0 : 1));
  for (double time = 0.0; time < seconds; time += 0.02) {
    for (int i = 0; i < per_wheels; ++i) estimate.update(of_imu(0.0, 0.0, 0.0), {3.0, 0.0}, step);
    estimate.update(of_wheels(wheels), {3.0, 0.0}, equal_stamps ? 0.0 : step);
  }
}

TEST(StateEstimate, rejected_wheels_are_used_again_after_the_same_time_at_any_rate_of_the_sensors) {
  for (const int per_wheels : {1, 2, 8}) {
    for (const bool equal_stamps : {false, true}) {
      const StateEstimateParams params{.rejection_time = 0.5};
      StateEstimate estimate{params};
      roll_in_messages(estimate, 3.0, 2.0, per_wheels, equal_stamps);
      roll_in_messages(estimate, 0.0, 0.45, per_wheels, equal_stamps);
      EXPECT_TRUE(estimate.estimate().wheels_rejected) << per_wheels << ", " << equal_stamps;
      EXPECT_NEAR(estimate.estimate().state.speed, 3.0, 0.1) << per_wheels << ", " << equal_stamps;
      roll_in_messages(estimate, 0.0, 0.15, per_wheels, equal_stamps);
      EXPECT_FALSE(estimate.estimate().wheels_rejected) << per_wheels << ", " << equal_stamps;
      EXPECT_NEAR(estimate.estimate().state.speed, 0.0, 0.1) << per_wheels << ", " << equal_stamps;
    }
  }
}

// A person drives a circle of 2 m/s and 1.5 rad/s, with or without a command and a steering angle that are known.
TEST(StateEstimate, an_unknown_command_is_not_taken_for_a_stop) {
  const double v = 2.0, r = 1.5;
  const double steering = std::atan(r * CarModel{}.wheelbase / v);
  for (const bool commanded : {false, true}) {
    for (const bool measured : {false, true}) {
      for (const bool accelerometer : {false, true}) {
        StateEstimate estimate{{.understeer = 0.0}};
        SensorReading reading = accelerometer ? of_imu(r, -0.171 * r * r, r * v) : of_imu(r, nan, nan);
        reading.wheel_speed = v;
        reading.steering_angle = measured ? steering : nan;
        const DriveCommand command = commanded ? DriveCommand{v, steering} : DriveCommand{nan, nan};
        for (int i = 0; i < 400; ++i) estimate.update(reading, command, period);
        const MotionEstimate found = estimate.estimate();
        EXPECT_NEAR(found.state.speed, v, 0.05) << commanded << measured << accelerometer;
        EXPECT_NEAR(found.state.yaw_rate, r, 0.05) << commanded << measured << accelerometer;
        EXPECT_NEAR(found.yaw_rate_bias, 0.0, 0.05) << commanded << measured << accelerometer;
      }
    }
  }
}

TEST(StateEstimate, a_command_that_becomes_unknown_no_longer_steers_it) {
  StateEstimate estimate{{.understeer = 0.0}};
  for (int i = 0; i < 80; ++i) estimate.update(of_wheels(2.0), {2.0, 0.3}, period);
  EXPECT_GT(estimate.estimate().state.yaw_rate, 1.0);
  SensorReading straight = of_wheels(2.0);
  straight.yaw_rate = 0.0;
  for (int i = 0; i < 80; ++i) estimate.update(straight, {nan, nan}, period);
  EXPECT_NEAR(estimate.estimate().state.yaw_rate, 0.0, 0.05);
}

TEST(StateEstimate, a_car_that_is_carried_does_not_learn_its_turning_as_a_bias) {
  StateEstimate estimate{StateEstimateParams{}};
  for (int i = 0; i < 40; ++i) estimate.update({0.0, 0.01, 0.0, 0.0, 0.0}, {nan, nan}, period);
  for (int i = 0; i < 200; ++i) estimate.update({0.0, 0.4, 0.0, 0.0, 0.0}, {nan, nan}, period);
  EXPECT_NEAR(estimate.estimate().yaw_rate_bias, 0.01, 0.01);
}

TEST(StateEstimate, new_parameters_keep_the_estimate) {
  StateEstimate estimate{StateEstimateParams{}};
  roll(estimate, 3.0);
  estimate.set_params({.speed_scale = 1.1}, CarModel{});
  EXPECT_NEAR(estimate.estimate().state.speed, 3.0, 0.01);
  EXPECT_THROW(estimate.set_params({.gate = -1.0}, CarModel{}), std::invalid_argument);
  for (int i = 0; i < 200; ++i) estimate.update({3.0, 0.0, 0.0, 0.0, 0.0}, {3.3, 0.0}, period);
  EXPECT_NEAR(estimate.estimate().state.speed, 3.3, 0.05);
}

TEST(StateEstimate, in_reverse_the_rear_axle_slips_outward_too) {
  const StateEstimateParams params{};
  StateEstimate estimate{params};
  for (int i = 0; i < 200; ++i) estimate.update({-2.0, 1.0, nan, nan, nan}, {-2.0, nan}, period);
  EXPECT_NEAR(estimate.estimate().lateral_speed, params.side_slip * 4.0 * 1.0, 0.02);
}

TEST(StateEstimate, rejects_one_outlier_of_the_gyro_but_not_many) {
  StateEstimate estimate{StateEstimateParams{}};
  roll(estimate, 2.0);
  estimate.update({2.0, 30.0, 0.0, 0.0, 0.0}, {2.0, 0.0}, period);
  EXPECT_NEAR(estimate.estimate().state.yaw_rate, 0.0, 0.05);
  for (int i = 0; i < 8; ++i) estimate.update(of_imu(30.0, nan, nan), {2.0, 0.0}, period);
  EXPECT_GT(estimate.estimate().state.yaw_rate, 25.0);
}

TEST(StateEstimate, a_scaled_wheel_and_an_offset_servo_are_corrected) {
  StateEstimate estimate{{.speed_scale = 1.1, .steering_offset = 0.05}};
  for (int i = 0; i < 200; ++i) estimate.update({2.0, 0.0, -0.05, nan, nan}, {2.2, -0.05}, period);
  EXPECT_NEAR(estimate.estimate().state.speed, 2.2, 0.01);
  EXPECT_NEAR(estimate.estimate().state.steering_angle, 0.0, 1e-6);
}

// Normalized estimation error squared over drives whose biases, slip and noise are as the filter assumes: its mean is 1
// (Bar-Shalom, Li and Kirubarajan, 2001, section 5.4). Slip times force is not linear, so that it may be up to 2 for
// the slip.
TEST(StateEstimate, its_errors_match_its_covariance) {
  const StateEstimateParams params{.acceleration_bias_drift = 0.0, .wheel_slip_drift = 0.0};
  Rng rng(11);
  constexpr int drives = 200;
  double speed_sum = 0.0, bias_sum = 0.0, slip_sum = 0.0;
  for (int drive = 0; drive < drives; ++drive) {
    StateEstimate estimate{params};
    const double bias = params.acceleration_bias_sigma * rng.gaussian();
    const double gyro_bias = params.yaw_rate_bias_sigma * rng.gaussian();
    const double slip = params.wheel_slip_sigma * rng.gaussian();
    double speed = rng.gaussian(), acceleration = 0.0;
    for (int i = 0; i < 200; ++i) {
      if (i % 20 == 0) acceleration = (speed > 3.0 ? -1.0 : 1.0) * (2.0 + 3.0 * rng.uniform());
      speed += acceleration * period;
      const double wheels = speed * (1.0 + slip * acceleration) + params.speed_sigma * rng.gaussian();
      const double measured_acceleration = acceleration + bias + params.acceleration_sigma * rng.gaussian();
      estimate.update({wheels, gyro_bias + params.yaw_rate_sigma * rng.gaussian(), 0.0, measured_acceleration, 0.0}, {},
                      period);
    }
    const auto& belief = estimate.belief();
    const auto share = [&](StateEstimate::Index i, double truth) {
      return square(belief.mean[i] - truth) / belief.covariance[i][i];
    };
    speed_sum += share(StateEstimate::speed, speed);
    bias_sum += share(StateEstimate::x_bias, bias);
    slip_sum += share(StateEstimate::slip, slip);
  }
  for (const double sum : {speed_sum, bias_sum, slip_sum}) {
    EXPECT_GT(sum / drives, 0.4);
    EXPECT_LT(sum / drives, 2.0);
  }
}

TEST(StateEstimate, without_time_nothing_changes) {
  StateEstimate estimate{StateEstimateParams{}};
  roll(estimate, 2.0);
  const MotionEstimate before = estimate.estimate();
  for (const double dt : {0.0, -1.0, nan}) estimate.update(unmeasured, {9.0, 0.3}, dt);
  EXPECT_EQ(estimate.estimate().state.speed, before.state.speed);
  EXPECT_EQ(estimate.estimate().state.yaw_rate, before.state.yaw_rate);
  EXPECT_EQ(estimate.estimate().state.steering_angle, before.state.steering_angle);
}

TEST(StateEstimate, a_reset_restores_the_initial_state) {
  StateEstimate estimate{StateEstimateParams{}}, fresh{StateEstimateParams{}};
  roll(estimate, 4.0);
  estimate.reset();
  roll(estimate, 2.0, 0.5);
  roll(fresh, 2.0, 0.5);
  EXPECT_EQ(estimate.belief().mean, fresh.belief().mean);
  EXPECT_EQ(estimate.belief().covariance, fresh.belief().covariance);
}

TEST(StateEstimate, an_invalid_parameter_is_named) {
  EXPECT_THROW(StateEstimate{{.speed_sigma = 0.0}}, std::invalid_argument);
  CarModel car{};
  car.servo_time_constant = 0.0;
  EXPECT_THROW((StateEstimate{StateEstimateParams{}, car}), std::invalid_argument);
}

TEST(StateEstimate, any_input_gives_a_finite_state_without_allocating) {
  StateEstimate estimate{StateEstimateParams{}};
  const std::array wild{nan, std::numeric_limits<double>::infinity(), -1e300, 1e300, 0.0, -1.0, 3.0, 1e-300};
  Rng rng(3);
  const auto pick = [&] { return wild[static_cast<std::size_t>(rng.uniform() * 7.999)]; };
  scene::allocations = 0;
  scene::counting = true;
  for (int i = 0; i < 20000; ++i) {
    estimate.update({pick(), pick(), pick(), pick(), pick()}, {pick(), pick()}, pick());
    const auto& belief = estimate.belief();
    for (std::size_t k = 0; k < StateEstimate::size; ++k) {
      ASSERT_TRUE(std::isfinite(belief.mean[k])) << i;
      ASSERT_TRUE(belief.covariance[k][k] >= 0.0 && std::isfinite(belief.covariance[k][k]))
          << i << " " << k << " " << belief.covariance[k][k];
    }
    ASSERT_TRUE(std::isfinite(estimate.estimate().state.steering_angle));
  }
  scene::counting = false;
  EXPECT_EQ(scene::allocations, 0);
}

}  // namespace
}  // namespace firstlap
