#include "firstlap/sim/sensors.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap::sim {
namespace {

TEST(Sensors, WithoutErrorsMeasureTheTruth) {
  Sensors sensors({.speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0}, 1);
  sensors.record(0.0, {1.0, 2.0, 0.3});
  sensors.record(0.1, {1.5, 2.5, 0.4});
  const VehicleState state = sensors.measure(0.1);
  EXPECT_EQ(state.speed, 1.5);
  EXPECT_EQ(state.yaw_rate, 2.5);
  EXPECT_EQ(state.steering_angle, 0.4);
}

TEST(Sensors, LatencyGivesAnEarlierState) {
  Sensors sensors({.speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0, .latency = 0.02}, 1);
  for (int i = 0; i < 2000; ++i) sensors.record(0.0025 * i, {0.0025 * i, 0.0, 0.0});
  EXPECT_NEAR(sensors.measure(0.0025 * 1999).speed, 0.0025 * 1999 - 0.02, 1e-9);
}

TEST(Sensors, HaveTheGivenScaleBiasAndNoise) {
  const SensorParams params{.speed_noise = 0.1, .speed_scale_error = 0.05, .yaw_rate_noise = 0.2, .yaw_rate_bias = 0.3};
  Sensors sensors(params, 9);
  sensors.record(0.0, {4.0, 1.0, 0.1});
  double speed = 0.0, squares = 0.0, yaw_rate = 0.0;
  constexpr int n = 100000;
  for (int i = 0; i < n; ++i) {
    const VehicleState state = sensors.measure(0.0);
    speed += state.speed;
    squares += (state.speed - 4.2) * (state.speed - 4.2);
    yaw_rate += state.yaw_rate;
  }
  EXPECT_NEAR(speed / n, 4.2, 2e-3);
  EXPECT_NEAR(std::sqrt(squares / n), 0.1, 1e-3);
  EXPECT_NEAR(yaw_rate / n, 1.3, 4e-3);
}

TEST(Sensors, SimulateTheFaultsOfOdometryNodes) {
  const auto measured = [](OdometryFault fault) {
    Sensors sensors(
        {.speed_noise = 0, .yaw_rate_noise = 0, .steering_noise = 0, .odometry_fault = static_cast<int>(fault)}, 1);
    sensors.record(0.0, {2.0, 1.0, 0.3}, 2.0);
    return sensors.measure(0.0);
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

}  // namespace
}  // namespace firstlap::sim
