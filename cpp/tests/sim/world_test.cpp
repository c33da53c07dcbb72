#include "firstlap/sim/world.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "firstlap/sim/car_body.hpp"
#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

using testing::annulus;
using testing::CenterDriver;
using testing::quiet;
using testing::wavy_track;

StepResult drive(World& world, Driver& driver) {
  const StepResult result = driver.step(world.scan(0), world.measured(0), world.period());
  world.command(0, result.command, 0.0);
  return result;
}

// The race is the reference: the same car, seed and driver give the same motion, bit for bit.
class OneCar : public ::testing::TestWithParam<Car> {};

Car wrong_car() {
  Car car;
  car.vehicle.speed_constant_error = 0.1;
  car.vehicle.steering_gain = 0.9;
  car.vehicle.steering_trim = 0.02;
  car.sensors.laser_x_error = 0.05;
  car.sensors.laser_y_error = -0.03;
  car.sensors.laser_yaw_error = 0.02;
  car.sensors.odometry_fault = static_cast<int>(OdometryFault::map_frame);
  return car;
}

INSTANTIATE_TEST_SUITE_P(World, OneCar, ::testing::Values(default_car(), wrong_car()));

TEST_P(OneCar, moves_as_in_a_race) {
  const Track track = wavy_track(400, 1.2, 0.1);
  CenterDriver raced(3.0), commanded(3.0);
  Race race(track, GetParam(), raced, {.laps = 2, .seed = 5});
  World world(track, GetParam(), {}, 5);
  while (race.result().laps.empty() && race.advance()) {
    world.advance();
    drive(world, commanded);
    ASSERT_EQ(race.pose().x, world.pose(0).x);
    ASSERT_EQ(race.pose().yaw, world.pose(0).yaw);
    ASSERT_TRUE(std::equal(race.scan().ranges.begin(), race.scan().ranges.end(), world.scan(0).ranges.begin()));
    ASSERT_EQ(race.measured().speed, world.measured(0).speed);
  }
  ASSERT_EQ(world.laps(0).size(), 1U);
  // The race's clock starts with the race, the world's laps with the first command.
  EXPECT_NEAR(race.result().laps[0].time - world.laps(0)[0].time, world.period(), 1e-9);
  EXPECT_EQ(world.contacts(0), 0);
}

// A box of walls is the reference for a car's body.
TEST(World, a_body_is_scanned_like_a_box_of_walls) {
  const CarGeometry geometry;
  const Pose2 laser{0.3, -0.2, 0.4};
  LidarParams params;
  for (const Pose2 body : {Pose2{2.0, 0.5, 0.3}, Pose2{-1.5, 0.2, 2.0}, Pose2{0.9, -0.9, -0.1}, Pose2{0.4, 3.0, 1.0}}) {
    const auto edges = body_edges(geometry, body);
    const Walls none, box(std::vector<WallSegment>(edges.begin(), edges.end()));
    std::vector<float> expected(static_cast<std::size_t>(params.beams)), drawn = expected;
    Lidar(params, box).scan(laser, expected);
    Lidar(params, none).scan(laser, drawn);
    draw_body(params, laser, edges, {0, params.beams}, drawn);
    int differing = 0, seen = 0;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      seen += std::isfinite(expected[i]);
      differing += std::isfinite(expected[i]) != std::isfinite(drawn[i]);
      if (!std::isfinite(expected[i]) || !std::isfinite(drawn[i])) continue;
      ASSERT_NEAR(expected[i], drawn[i], 1e-4);
    }
    EXPECT_GT(seen, 10);
    EXPECT_LE(differing, 2) << "only at the ends of the body";
  }
}

TEST(World, cars_see_and_touch_each_other) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {.cars = 2, .gap = 3.0}, 1);
  world.advance();
  const auto ranges = world.scan(1).ranges;
  const auto nearest = *std::min_element(ranges.begin() + 500, ranges.begin() + 620);
  EXPECT_NEAR(nearest, 2.6, 0.1);
  while (world.contacts(1) == 0 && world.time() < 20.0) {
    world.command(1, {3.0, std::atan(0.33 / 10.0)}, 0.0);
    world.advance();
  }
  EXPECT_EQ(world.contacts(1), 1);
  EXPECT_TRUE(world.standing(1));
  EXPECT_LT(world.time(), 5.0);
}

TEST(World, a_car_without_commands_is_stopped_after_the_timeout) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {.command_timeout = 0.2}, 1);
  for (int i = 0; i < 40; ++i) {
    world.command(0, {2.0, std::atan(0.33 / 10.0)}, 0.0);
    world.advance();
  }
  const double speed = world.state(0).speed;
  EXPECT_NEAR(speed, 2.0, 0.1);
  for (int i = 0; i < 7; ++i) world.advance();
  EXPECT_NEAR(world.state(0).speed, speed, 0.1);
  for (int i = 0; i < 60; ++i) world.advance();
  EXPECT_NEAR(world.state(0).speed, 0.0, 0.01);
}

TEST(World, a_reset_returns_the_car_to_its_start_and_clears_a_contact) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {}, 1);
  const Pose2 start = world.pose(0);
  for (int i = 0; i < 400 && world.contacts(0) == 0; ++i) {
    world.command(0, {3.0, 0.0}, 0.0);
    world.advance();
  }
  ASSERT_EQ(world.contacts(0), 1);
  const Pose2 there = world.pose(0);
  world.command(0, {3.0, 0.0}, 0.0);
  world.advance();
  EXPECT_EQ(world.pose(0).x, there.x);
  world.reset(0);
  EXPECT_EQ(world.pose(0).x, start.x);
  EXPECT_EQ(world.contacts(0), 0);
  world.command(0, {1.0, std::atan(0.33 / 10.0)}, 0.0);
  for (int i = 0; i < 8; ++i) world.advance();
  EXPECT_GT(world.state(0).speed, 0.2);
}

TEST(World, a_kick_pushes_the_car_aside) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {}, 1);
  for (int i = 0; i < 40; ++i) {
    world.command(0, {3.0, std::atan(0.33 / 10.0)}, 0.0);
    world.advance();
  }
  const double before = world.lateral_offset(0), rate = world.state(0).yaw_rate;
  world.kick(0, 0.5, 2.0);
  EXPECT_NEAR(world.state(0).yaw_rate, rate + 2.0, 1e-9);
  for (int i = 0; i < 8; ++i) {
    world.command(0, {3.0, std::atan(0.33 / 10.0)}, 0.0);
    world.advance();
  }
  EXPECT_GT(std::abs(world.lateral_offset(0) - before), 0.02);
}

// In a curve that the car takes on dry ground, on wet ground it slides to the wall; until then its motion continues.
TEST(World, friction_changes_under_the_moving_car) {
  const Track track = annulus(3.0, 1.2);
  const auto lap_of = [&](double mu_scale) {
    World world(track, quiet(default_car()), {}, 1);
    for (int i = 0; i < 200 && world.contacts(0) == 0; ++i) {
      if (i == 60) {
        const Pose2 before = world.pose(0);
        world.change(quiet(default_car()), mu_scale);
        EXPECT_EQ(world.pose(0).x, before.x);
        EXPECT_EQ(world.pose(0).y, before.y);
      }
      const double out = world.lateral_offset(0);
      world.command(0, {3.3, std::atan(0.33 / 3.0) - 0.15 * out}, 0.0);
      world.advance();
    }
    return world.contacts(0);
  };
  EXPECT_EQ(lap_of(1.0), 0);
  EXPECT_EQ(lap_of(0.3), 1);
}

TEST(World, drivers_are_given_the_estimate_where_the_car_has_one) {
  const Track track = annulus(10.0, 1.5);
  Car car = default_car();
  World world(track, car, {}, 1);
  world.advance();
  EXPECT_EQ(world.measured(0).speed, world.reading(0).wheel_speed);
  car.state_estimate.enabled = true;
  world.change(car, 1.0);
  world.advance();
  EXPECT_NE(world.measured(0).speed, world.reading(0).wheel_speed);
  car.state_estimate.speed_sigma = -1.0;
  EXPECT_THROW(world.change(car, 1.0), std::invalid_argument);
}

TEST(World, changed_sensors_and_lidar_apply_to_the_next_scan) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {}, 1);
  world.advance();
  const std::vector<float> before(world.scan(0).ranges.begin(), world.scan(0).ranges.end());
  Car noisy = quiet(default_car());
  noisy.lidar.noise_sigma = 0.1;
  noisy.sensors.yaw_rate_bias = 0.5;
  world.change(noisy, 1.0);
  world.advance();
  EXPECT_NEAR(world.measured(0).yaw_rate, 0.5, 1e-6);
  double squares = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i) squares += std::pow(world.scan(0).ranges[i] - before[i], 2.0);
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(before.size())), 0.1, 0.01);
}

TEST(World, a_forbidden_change_while_driving_is_refused_and_changes_nothing) {
  const Track track = annulus(10.0, 1.5);
  World world(track, quiet(default_car()), {}, 1);
  const auto refused = [&](auto&& alter, double mu_scale) {
    Car car = quiet(default_car());
    car.sensors.yaw_rate_bias = 0.5;
    alter(car);
    EXPECT_THROW(world.change(car, mu_scale), std::invalid_argument);
    world.advance();
    EXPECT_NEAR(world.measured(0).yaw_rate, 0.0, 1e-6);
  };
  refused([](Car& car) { car.lidar.beams = 541; }, 1.0);
  refused([](Car& car) { car.lidar.rate = 20.0; }, 1.0);
  refused([](Car& car) { car.vehicle.model = 1; }, 1.0);
  refused([](Car& car) { car.vehicle.friction = -1.0; }, 1.0);
  refused([](Car& car) { car.sensors.latency = 5.0; }, 1.0);
  refused([](Car&) {}, 100.0);
}

TEST(World, a_car_fits_where_there_is_no_wall_and_no_other_car) {
  const Track track = annulus(10.0, 1.5);
  const World world(track, default_car(), {.cars = 2, .gap = 3.0}, 1);
  const Pose2 first = world.pose(0), second = world.pose(1);
  EXPECT_TRUE(world.fits(0, first));
  EXPECT_FALSE(world.fits(0, second));
  EXPECT_TRUE(world.fits(1, second));
  EXPECT_FALSE(world.fits(0, {first.x * 0.86, first.y * 0.86, first.yaw}));
}

TEST(World, cars_that_do_not_fit_are_refused) {
  const Track track = annulus(3.0, 0.6);
  const double seventh = 2.0 * 3.14159265 * 3.0 / 7.0;  // the eighth car starts where the first one is
  EXPECT_THROW(World(track, default_car(), {.cars = 8, .gap = seventh}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
