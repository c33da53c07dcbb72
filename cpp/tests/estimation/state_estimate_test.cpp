#include "firstlap/estimation/state_estimate.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "firstlap/sim/car.hpp"
#include "firstlap/sim/sensors.hpp"
#include "firstlap/sim/vehicle.hpp"
#include "support/allocations.hpp"

namespace firstlap {
namespace {

struct Errors {
  double speed = 0.0, yaw_rate = 0.0, steering = 0.0;              // RMS of the estimate
  double raw_speed = 0.0, raw_yaw_rate = 0.0, raw_steering = 0.0;  // RMS of the measured, or commanded, values
};

// A slalom at 2 to 5 m/s with poor sensors, compared with the simulated truth. `gyro` scales the gyro noise.
Errors slalom(const sim::SensorParams& bad, StateEstimate& estimate, double seconds) {
  const sim::Car car = sim::default_car();
  sim::Vehicle vehicle(car.geometry, car.vehicle);
  sim::Sensors sensors(bad, 7);
  const double period = 0.025;
  const int steps = static_cast<int>(std::ceil(period / car.vehicle.step_dt - 1e-9));
  Errors sum;
  int count = 0;
  double time = 0.0;
  while (time < seconds) {
    const bool standing = time < 1.0;
    const DriveCommand command{standing ? 0.0 : 3.5 + 1.5 * std::sin(0.9 * time),
                               standing ? 0.0 : 0.15 * std::sin(2.0 * time)};
    vehicle.command(command);
    for (int i = 0; i < steps; ++i) vehicle.step(period / steps);
    time += period;
    const VehicleState truth = vehicle.state();
    sensors.record(time, truth);
    const VehicleState measured = sensors.measure(time);
    estimate.predict(command, period);
    estimate.measure_speed(measured.speed);
    estimate.measure_yaw_rate(measured.yaw_rate);
    if (time < 2.0) continue;
    const VehicleState found = estimate.state();
    const auto add = [](double& total, double error) { total += error * error; };
    add(sum.speed, found.speed - truth.speed);
    add(sum.yaw_rate, found.yaw_rate - truth.yaw_rate);
    add(sum.steering, found.steering_angle - truth.steering_angle);
    add(sum.raw_speed, measured.speed - truth.speed);
    add(sum.raw_yaw_rate, measured.yaw_rate - truth.yaw_rate);
    add(sum.raw_steering, command.steering_angle - truth.steering_angle);
    ++count;
  }
  for (double* total :
       {&sum.speed, &sum.yaw_rate, &sum.steering, &sum.raw_speed, &sum.raw_yaw_rate, &sum.raw_steering}) {
    *total = std::sqrt(*total / count);
  }
  return sum;
}

TEST(StateEstimate, IsCloserToTheSimulatedTruthThanPoorSensors) {
  sim::SensorParams bad;
  bad.speed_noise = 0.3;
  bad.yaw_rate_noise = 0.3;
  bad.yaw_rate_bias = 0.2;
  StateEstimateParams params;
  params.speed_sigma = 0.3;
  params.yaw_rate_sigma = 0.3;
  StateEstimate estimate(params);
  const Errors errors = slalom(bad, estimate, 60.0);
  EXPECT_LT(errors.speed, 0.6 * errors.raw_speed);
  EXPECT_LT(errors.yaw_rate, 0.5 * errors.raw_yaw_rate);
  EXPECT_LT(errors.steering, 0.7 * errors.raw_steering);
  EXPECT_NEAR(estimate.yaw_rate_bias(), 0.2, 0.05);
}

TEST(StateEstimate, HardlyDegradesGoodSensors) {
  StateEstimateParams params;
  params.speed_sigma = 0.03;
  params.yaw_rate_sigma = 0.02;
  StateEstimate estimate(params);
  const Errors errors = slalom({}, estimate, 30.0);
  EXPECT_LT(errors.speed, 1.2 * errors.raw_speed);
  EXPECT_LT(errors.yaw_rate, 1.2 * errors.raw_yaw_rate);
}

TEST(StateEstimate, FindsTheGyroBiasAtStandstill) {
  StateEstimate estimate{StateEstimateParams{}};
  for (int i = 0; i < 80; ++i) {
    estimate.predict({}, 0.025);
    estimate.measure_speed(0.0);
    estimate.measure_yaw_rate(0.3);
  }
  EXPECT_NEAR(estimate.yaw_rate_bias(), 0.3, 0.01);
  EXPECT_NEAR(estimate.state().yaw_rate, 0.0, 0.01);
}

TEST(StateEstimate, PredictsTheYawRateFromTheSteeringAngleWithoutAGyro) {
  StateEstimateParams params;
  params.understeer = 0.0;
  StateEstimate estimate(params);
  for (int i = 0; i < 80; ++i) {
    estimate.predict({1.0, 0.2}, 0.025);
    estimate.measure_speed(1.0);
  }
  EXPECT_NEAR(estimate.state().yaw_rate, std::tan(0.2) / 0.33, 0.02);
  EXPECT_NEAR(estimate.state().steering_angle, 0.2, 1e-3);
}

TEST(StateEstimate, RejectsOneOutlierButNotMany) {
  StateEstimate estimate{StateEstimateParams{}};
  const auto measure = [&](double speed) {
    estimate.predict({2.0, 0.0}, 0.025);
    estimate.measure_speed(speed);
  };
  for (int i = 0; i < 80; ++i) measure(2.0);
  measure(30.0);
  EXPECT_NEAR(estimate.state().speed, 2.0, 0.1);
  for (int i = 0; i < 40; ++i) measure(6.0);
  EXPECT_NEAR(estimate.state().speed, 6.0, 0.1);
}

TEST(StateEstimate, AnInvalidParameterIsNamed) {
  StateEstimateParams params;
  params.speed_sigma = 0.0;
  EXPECT_THROW(StateEstimate{params}, std::invalid_argument);
}

TEST(StateEstimate, AnyInputGivesAFiniteStateWithoutAllocating) {
  StateEstimate estimate{StateEstimateParams{}};
  const double wild[] = {std::numeric_limits<double>::quiet_NaN(),
                         std::numeric_limits<double>::infinity(),
                         -1e300,
                         1e300,
                         0.0,
                         -1.0,
                         3.0,
                         1e-300};
  scene::allocations = 0;
  scene::counting = true;
  for (int i = 0; i < 20000; ++i) {
    const auto pick = [&](int factor) { return wild[static_cast<std::size_t>((i * factor + i / 7) % 8)]; };
    estimate.predict({pick(1), pick(3)}, pick(5));
    estimate.measure_speed(pick(7));
    estimate.measure_yaw_rate(pick(11));
    estimate.measure_steering(pick(13));
    const VehicleState state = estimate.state();
    ASSERT_TRUE(std::isfinite(state.speed) && std::isfinite(state.yaw_rate) && std::isfinite(state.steering_angle));
    ASSERT_TRUE(std::isfinite(estimate.yaw_rate_bias()));
  }
  scene::counting = false;
  EXPECT_EQ(scene::allocations, 0);
}

}  // namespace
}  // namespace firstlap
