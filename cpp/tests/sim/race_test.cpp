#include "firstlap/sim/race.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "firstlap/sim/cpu_clock.hpp"
#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

using testing::annulus;
using testing::CenterDriver;
using testing::FixedDriver;
using testing::quiet;
using testing::wavy_track;

// All results but the computing times.
void expect_identical(const RaceResult& a, const RaceResult& b) {
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.distance, b.distance);
  ASSERT_EQ(a.laps.size(), b.laps.size());
  for (std::size_t i = 0; i < a.laps.size(); ++i) EXPECT_EQ(a.laps[i].time, b.laps[i].time);
  ASSERT_EQ(a.path.size(), b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    ASSERT_EQ(a.path[i].x, b.path[i].x);
    ASSERT_EQ(a.path[i].command_steering_angle, b.path[i].command_steering_angle);
  }
}

TEST(Race, a_center_following_driver_finishes_its_laps) {
  const Track track = wavy_track(400, 1.2, 0.1);
  CenterDriver driver(3.0);
  const RaceResult result = run(track, default_car(), driver, {.laps = 2});
  EXPECT_EQ(result.outcome, Outcome::finished);
  ASSERT_EQ(result.laps.size(), 2U);
  EXPECT_TRUE(result.laps[0].standing);
  EXPECT_FALSE(result.laps[1].standing);
  EXPECT_GT(result.laps[0].time, result.laps[1].time);
  EXPECT_NEAR(result.time, result.laps[0].time + result.laps[1].time, 1e-9);
  EXPECT_NEAR(result.distance, result.laps[0].distance + result.laps[1].distance, 1e-9);
  EXPECT_EQ(result.path.size(), result.compute_times.size());
  EXPECT_GT(result.laps[1].min_clearance, 0.0);
  EXPECT_EQ(driver.resets, 1);
}

TEST(Race, the_same_seed_gives_the_same_race_and_another_seed_another) {
  const Track track = wavy_track(400, 1.2, 0.1);
  CenterDriver driver(3.0);
  const RaceResult a = run(track, default_car(), driver, {.laps = 1, .seed = 5});
  const RaceResult b = run(track, default_car(), driver, {.laps = 1, .seed = 5});
  const RaceResult c = run(track, default_car(), driver, {.laps = 1, .seed = 6});
  expect_identical(a, b);
  EXPECT_NE(a.time, c.time);
}

// On a circle with constant steering the rear axle keeps R = L / tan(delta): a flying lap takes 2 pi R / v.
TEST(Race, lap_time_on_a_circle_is_exact_and_not_a_multiple_of_the_step) {
  Car car = quiet(default_car());
  const double radius = 5.0, steering = std::atan(car.geometry.wheelbase / radius);
  const Track track = annulus(radius, 1.0);
  FixedDriver driver({0.7, steering});
  const RaceResult result = run(track, car, driver, {.laps = 3});
  ASSERT_EQ(result.outcome, Outcome::finished);
  const double expected = 2.0 * std::numbers::pi * radius / 0.7;
  EXPECT_NEAR(result.laps[1].time, expected, 2e-3);
  EXPECT_NEAR(result.laps[2].time, expected, 2e-3);
  EXPECT_NEAR(result.laps[2].mean_speed, 0.7, 1e-4);
  EXPECT_NEAR(result.laps[2].min_clearance, radius - 0.155 - (radius - 1.0), 0.05);
}

TEST(Race, lap_times_do_not_depend_on_the_scan_rate) {
  Car fast = quiet(default_car()), slow = fast;
  slow.lidar.rate = 17.0;
  const double steering = std::atan(fast.geometry.wheelbase / 5.0);
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({0.7, steering});
  const double a = run(track, fast, driver, {.laps = 2}).laps.at(1).time;
  const double b = run(track, slow, driver, {.laps = 2}).laps.at(1).time;
  EXPECT_NEAR(a, b, 1e-4);
}

TEST(Race, a_wall_ends_the_race_where_the_car_touches_it) {
  const Track track = annulus(8.0, 1.0);
  FixedDriver driver({2.0, 0.0});
  const RaceResult result = run(track, quiet(default_car()), driver);
  ASSERT_EQ(result.outcome, Outcome::contact);
  ASSERT_TRUE(result.contact.has_value());
  EXPECT_NEAR(std::hypot(result.contact->x, result.contact->y), 9.0, 0.01);
  const CarGeometry car;  // straight on from (8, 0): the right front corner first
  EXPECT_NEAR(result.contact->y, std::sqrt(81.0 - 8.155 * 8.155), 0.02);
  EXPECT_EQ(result.contact->time, result.time);
  EXPECT_TRUE(result.laps.empty());
}

TEST(Race, a_car_that_does_not_move_is_stuck) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({0.0, 0.0});
  const RaceResult result = run(track, quiet(default_car()), driver);
  EXPECT_EQ(result.outcome, Outcome::stuck);
  EXPECT_NEAR(result.time, 3.0, 0.03);
}

TEST(Race, a_car_that_crawls_times_out) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({0.2, std::atan(0.33 / 5.0)});
  const RaceResult result = run(track, quiet(default_car()), driver);
  EXPECT_EQ(result.outcome, Outcome::timeout);
  EXPECT_NEAR(result.time, 2.0 * std::numbers::pi * 5.0 / 0.3, 0.1);
}

TEST(Race, driving_backwards_around_the_track_is_the_wrong_way_and_no_lap) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({0.7, -std::atan(0.33 / 5.0)});
  const RaceResult result = run(track, quiet(default_car()), driver, {.start_yaw = std::numbers::pi});
  EXPECT_EQ(result.outcome, Outcome::wrong_way);
  EXPECT_TRUE(result.laps.empty());
}

TEST(Race, a_start_on_a_wall_is_refused) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({1.0, 0.0});
  EXPECT_THROW(Race(track, default_car(), driver, {.start_offset = 1.0}), std::invalid_argument);
  EXPECT_THROW(Race(track, default_car(), driver, {.laps = 0}), std::invalid_argument);
}

TEST(Race, a_start_beyond_a_wall_is_refused) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({1.0, 0.0});
  for (const double offset : {10.0, 4.0, -3.0, -9.0}) {
    try {
      const Race race(track, default_car(), driver, {.start_offset = offset});
      FAIL() << offset;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("beyond a wall"), std::string::npos) << error.what();
    }
  }
  for (const double offset : {-0.5, 0.0, 0.5})
    EXPECT_NO_THROW(Race(track, default_car(), driver, {.start_offset = offset})) << offset;
}

TEST(Race, a_stationary_car_scans_as_the_lidar_does) {
  const Track track = wavy_track();
  FixedDriver driver({0.0, 0.0});
  const Car car = quiet(default_car());
  Race race(track, car, driver);
  race.advance();
  Lidar lidar(car.lidar, track.walls);
  std::vector<float> expected(1081);
  const Pose2 pose = race.pose();
  lidar.scan({pose.x + 0.27 * std::cos(pose.yaw), pose.y + 0.27 * std::sin(pose.yaw), pose.yaw}, expected);
  for (std::size_t i = 0; i < 1081; ++i) ASSERT_EQ(race.scan().ranges[i], expected[i]) << i;
}

// Straight ahead along a corridor with a wall at each end: each beam is measured from where the car was at its time.
TEST(Race, beams_of_a_moving_car_are_measured_along_the_sweep) {
  Track track{Walls({{-50, -3, 50, -3}, {50, -3, 50, 3}, {50, 3, -50, 3}, {-50, 3, -50, -3}}),
              {{0, 0}, {10, 0}, {20, 0}, {20, 1}, {-20, 1}, {-20, 0}}};
  Car car = quiet(default_car());
  car.lidar.range_max = 100.0;
  car.lidar.beams = 3;
  car.lidar.fov = std::numbers::pi;
  FixedDriver driver({4.0, 0.0});
  Race race(track, car, driver);
  for (int i = 0; i < 80; ++i) ASSERT_TRUE(race.advance());
  const double speed = race.state().speed, nose = race.pose().x + car.geometry.laser_x;
  EXPECT_GT(speed, 3.9);
  const double middle = 50.0 - static_cast<double>(race.scan().ranges[1]);  // position of the LiDAR half a sweep ago
  EXPECT_NEAR(middle, nose - 0.5 * car.lidar.sweep_time * speed, 0.0013 * speed);
  EXPECT_NEAR(race.scan().time_increment, 0.01875 / 2, 1e-12);
}

TEST(Race, compute_latency_delays_the_command) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({2.0, 0.0});
  const auto speed_after = [&](double latency) {
    Race race(track, quiet(default_car()), driver, {.compute_latency = latency});
    for (int i = 0; i < 4; ++i) race.advance();
    return race.state().speed;
  };
  EXPECT_GT(speed_after(0.0), 0.4);
  EXPECT_EQ(speed_after(0.1), 0.0);
}

// Steers by its step count, so that every command is different; computes for the given time.
class SlowDriver : public Driver {
 public:
  explicit SlowDriver(double seconds = 0.0) : seconds_(seconds) {}
  StepResult step(const LaserScan&, const VehicleState&, double dt) noexcept override {
    pauses.push_back(dt);
    const double begin = cpu_seconds();
    while (cpu_seconds() - begin < seconds_) {
    }
    return {{1.0, 0.0}, Status::ok};
  }
  void reset() noexcept override { pauses.reserve(1000); }
  std::vector<double> pauses{};

 private:
  double seconds_;
};

TEST(Race, a_fast_driver_gets_every_scan_and_a_slow_one_skips_some) {
  const Track track = annulus(5.0, 1.0);
  const auto drive = [&](double latency, SlowDriver& driver) {
    Race race(track, quiet(default_car()), driver, {.compute_latency = latency});
    for (int i = 0; i < 41; ++i) race.advance();
    return race.take_result();
  };
  SlowDriver quick, late, later;
  EXPECT_EQ(drive(0.024, quick).skipped_scans, 0);
  EXPECT_EQ(quick.pauses.size(), 41U);
  // 60 ms per scan: it starts with the newest scan as soon as it is free, at 25, 85, 145 ms, ...
  const RaceResult result = drive(0.06, late);
  EXPECT_NEAR(static_cast<double>(late.pauses.size()), 1.0 + 1.0 / 0.06, 1.01);
  EXPECT_EQ(late.pauses.size() + static_cast<std::size_t>(result.skipped_scans) + 1, 41U) << "one still waits";
  EXPECT_EQ(result.compute_times.size(), late.pauses.size());
  EXPECT_NEAR(late.pauses[1], 0.05, 1e-9) << "dt is the interval between the scans it got";
  drive(0.25, later);
  EXPECT_LE(later.pauses.size(), 5U);
}

TEST(Race, a_driver_that_stays_on_the_track_leaves_it_with_latency) {
  const Track track = wavy_track(400, 1.2, 0.1);
  CenterDriver driver(3.0);
  EXPECT_EQ(run(track, default_car(), driver, {.laps = 1}).outcome, Outcome::finished);
  EXPECT_EQ(run(track, default_car(), driver, {.laps = 1, .compute_latency = 0.3}).outcome, Outcome::contact);
}

TEST(Race, a_fixed_latency_is_reproducible) {
  const Track track = wavy_track(400, 1.2, 0.1);
  CenterDriver driver(2.0);
  const RaceOptions options{.laps = 1, .seed = 5, .compute_latency = 0.033};
  expect_identical(run(track, default_car(), driver, options), run(track, default_car(), driver, options));
}

TEST(Race, a_measured_latency_is_the_compute_time_of_the_driver) {
  const Track track = annulus(5.0, 1.0);
  SlowDriver slow(0.03), quick;
  Race race(track, quiet(default_car()), slow, {.measure_latency = true});
  for (int i = 0; i < 12; ++i) race.advance();
  EXPECT_GE(race.result().skipped_scans, 1) << "30 ms do not fit between two scans";
  Race other(track, quiet(default_car()), slow, {.measure_latency = false});
  for (int i = 0; i < 12; ++i) other.advance();
  EXPECT_EQ(other.result().skipped_scans, 0);
}

TEST(Race, the_driver_is_given_the_measured_state_or_the_estimate) {
  const Track track = wavy_track(400, 1.2, 0.1);
  Car car = default_car();
  for (const bool enabled : {false, true}) {
    car.state_estimate.enabled = enabled;
    CenterDriver driver(3.0);
    Race race(track, car, driver, {.laps = 1, .seed = 3});
    StateEstimate estimate(car.state_estimate, model_of(car));
    DriveCommand before{};
    while (race.advance()) {
      estimate.update(race.reading(), before, 1.0 / car.lidar.rate);
      before = race.step_result().command;
      const VehicleState expected = enabled ? estimate.estimate().state : as_measured(race.reading());
      ASSERT_EQ(race.measured().speed, expected.speed);
      ASSERT_EQ(race.measured().yaw_rate, expected.yaw_rate);
      ASSERT_EQ(race.measured().steering_angle, expected.steering_angle);
    }
    EXPECT_EQ(race.result().outcome, Outcome::finished);
  }
}

TEST(Race, starts_anywhere_and_counts_laps_from_there) {
  const Track track = annulus(5.0, 1.0);
  FixedDriver driver({0.7, std::atan(0.33 / 5.0)});
  const RaceResult result = run(track, quiet(default_car()), driver, {.laps = 1, .start_s = 20.0});
  ASSERT_EQ(result.outcome, Outcome::finished);
  EXPECT_NEAR(result.path.front().s, 20.0, 0.1);
  EXPECT_NEAR(result.path.back().s, 20.0, 0.1);
}

TEST(Race, every_car_finishes_with_noise_over_many_seeds) {
  const Track track = wavy_track(400, 1.2, 0.1);
  for (const Car& car : {default_car(), nuc2_car(), gym_car()}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      CenterDriver driver(2.5);
      EXPECT_EQ(run(track, car, driver, {.laps = 1, .seed = seed}).outcome, Outcome::finished) << seed;
    }
  }
}

}  // namespace
}  // namespace firstlap::sim
