#include "firstlap/sim/sensors.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap::sim {
namespace {

constexpr SensorParams exact{
    .speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0, .acceleration_noise = 0, .vibration = 0};

TEST(Sensors, without_errors_measure_the_truth) {
  Sensors sensors(exact, 1);
  sensors.record(0.0, {.state = {1.0, 2.0, 0.3}});
  sensors.record(0.1, {.state = {1.5, 2.5, 0.4}, .acceleration = {3.0, -4.0}});
  const SensorReading reading = sensors.read(0.1);
  EXPECT_EQ(reading.wheel_speed, 1.5);
  EXPECT_EQ(reading.yaw_rate, 2.5);
  EXPECT_EQ(reading.steering_angle, 0.4);
  EXPECT_DOUBLE_EQ(reading.acceleration_x, 3.0);
  EXPECT_DOUBLE_EQ(reading.acceleration_y, -4.0);
}

TEST(Sensors, latency_gives_an_earlier_state) {
  Sensors sensors({.speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0, .latency = 0.02}, 1);
  for (int i = 0; i < 2000; ++i) sensors.record(0.0025 * i, {.state = {0.0025 * i, 0.0, 0.0}});
  EXPECT_NEAR(sensors.read(0.0025 * 1999).wheel_speed, 0.0025 * 1999 - 0.02, 1e-9);
}

TEST(Sensors, have_the_given_scale_bias_and_noise) {
  const SensorParams params{.speed_noise = 0.1, .speed_scale_error = 0.05, .yaw_rate_noise = 0.2, .yaw_rate_bias = 0.3};
  Sensors sensors(params, 9);
  sensors.record(0.0, {.state = {4.0, 1.0, 0.1}});
  double speed = 0.0, squares = 0.0, yaw_rate = 0.0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const SensorReading reading = sensors.read(0.0);
    speed += reading.wheel_speed;
    squares += (reading.wheel_speed - 4.2) * (reading.wheel_speed - 4.2);
    yaw_rate += reading.yaw_rate;
  }
  EXPECT_NEAR(speed / n, 4.2, 2e-3);
  EXPECT_NEAR(std::sqrt(squares / n), 0.1, 1e-3);
  EXPECT_NEAR(yaw_rate / n, 1.3, 4e-3);
}

TEST(Sensors, simulate_the_faults_of_odometry_nodes) {
  const auto measured = [](OdometryFault fault) {
    Sensors sensors(
        {.speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0, .odometry_fault = static_cast<int>(fault)}, 1);
    sensors.record(0.0, {.state = {2.0, 1.0, 0.3}, .yaw = 2.0});
    return as_measured(sensors.read(0.0));
  };
  EXPECT_EQ(measured(OdometryFault::none).speed, 2.0);
  EXPECT_EQ(measured(OdometryFault::negated).speed, -2.0);
  EXPECT_EQ(measured(OdometryFault::map_frame).speed, 2.0 * std::cos(2.0));
  EXPECT_EQ(measured(OdometryFault::km_h).speed, 7.2);
  EXPECT_NEAR(measured(OdometryFault::deg_s).yaw_rate, 57.29578, 1e-5);
  EXPECT_EQ(measured(OdometryFault::deg_s).speed, 2.0);
  EXPECT_EQ(measured(OdometryFault::stuck).speed, 0.0);
  EXPECT_EQ(measured(OdometryFault::stuck).yaw_rate, 0.0);
  EXPECT_EQ(measured(OdometryFault::stuck).steering_angle, 0.3);
}

TEST(Sensors, wheels_slip_in_proportion_to_the_force_of_the_tires) {
  SensorParams params = exact;
  params.wheel_slip = 0.03;
  Sensors sensors(params, 1);
  sensors.record(0.0, {.state = {4.0, 0.0, 0.0}, .acceleration = {-2.0, 0.0}, .drive = 5.0});
  EXPECT_DOUBLE_EQ(sensors.read(0.0).wheel_speed, 4.0 * 1.15);
  sensors.record(0.1, {.state = {4.0, 0.0, 0.0}, .acceleration = {2.0, 0.0}, .drive = -5.0});
  EXPECT_DOUBLE_EQ(sensors.read(0.1).wheel_speed, 4.0 * 0.85);
}

TEST(Sensors, wheels_lock_under_hard_braking_and_spin_up_again) {
  SensorParams params = exact;
  params.wheel_lock_deceleration = 4.0;
  params.wheel_lock_time = 0.05;
  Sensors sensors(params, 1);
  double time = 0.0;
  const auto brake = [&](double deceleration, double seconds) {
    for (const double end = time + seconds; time < end - 1e-9; time += 0.0025) {
      sensors.record(time, {.state = {3.0, 0.0, 0.0}, .drive = -deceleration});
    }
    return sensors.read(time).wheel_speed;
  };
  EXPECT_EQ(brake(3.9, 0.2), 3.0);
  EXPECT_NEAR(brake(4.1, 0.05), 3.0 * std::exp(-1.0), 1e-9);
  EXPECT_LT(brake(4.1, 0.5), 0.01);
  EXPECT_NEAR(brake(0.0, 0.5), 3.0, 0.01);
}

TEST(Sensors, the_accelerometer_gives_the_mean_since_the_last_reading) {
  Sensors sensors(exact, 1);
  for (int i = 0; i <= 10; ++i) sensors.record(0.01 * i, {.acceleration = {1.0, 0.0}});
  EXPECT_NEAR(sensors.read(0.1).acceleration_x, 1.0, 1e-12);
  for (int i = 11; i <= 20; ++i) sensors.record(0.01 * i, {.acceleration = {i <= 15 ? 2.0 : 6.0, -1.0}});
  const SensorReading reading = sensors.read(0.2);
  EXPECT_NEAR(reading.acceleration_x, 4.0, 1e-12);
  EXPECT_NEAR(reading.acceleration_y, -1.0, 1e-12);
}

TEST(Sensors, the_accelerometer_has_bias_noise_and_the_vibration_of_a_moving_car) {
  SensorParams params = exact;
  params.acceleration_noise = 0.05;
  params.vibration = 0.4;
  params.acceleration_x_bias = 0.3;
  params.acceleration_y_bias = -0.2;
  for (const double speed : {0.0, 2.0}) {
    Sensors sensors(params, 9);
    sensors.record(0.0, {.state = {speed, 0.0, 0.0}});
    double x = 0.0, y = 0.0, squares = 0.0;
    constexpr int n = 100000;
    for (int i = 0; i < n; ++i) {
      const SensorReading reading = sensors.read(0.0);
      x += reading.acceleration_x;
      y += reading.acceleration_y;
      squares += (reading.acceleration_x - 0.3) * (reading.acceleration_x - 0.3);
    }
    EXPECT_NEAR(x / n, 0.3, 5e-3);
    EXPECT_NEAR(y / n, -0.2, 5e-3);
    EXPECT_NEAR(std::sqrt(squares / n), speed > 0.0 ? std::hypot(0.05, 0.4) : 0.05, 5e-3);
  }
}

TEST(Sensors, accelerometer_noise_changes_no_other_reading) {
  SensorParams loud{};
  loud.acceleration_noise = 2.0;
  loud.vibration = 3.0;
  Sensors sensors({}, 4), others(loud, 4);
  for (int i = 0; i < 100; ++i) {
    for (Sensors* each : {&sensors, &others}) each->record(0.025 * i, {.state = {2.0, 1.0, 0.1}});
    const VehicleState a = as_measured(sensors.read(0.025 * i)), b = as_measured(others.read(0.025 * i));
    ASSERT_EQ(a.speed, b.speed);
    ASSERT_EQ(a.yaw_rate, b.yaw_rate);
    ASSERT_EQ(a.steering_angle, b.steering_angle);
  }
}

}  // namespace
}  // namespace firstlap::sim
