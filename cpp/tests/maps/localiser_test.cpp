#include "firstlap/maps/localiser.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <stdexcept>

#include "tests/core/allocations.hpp"
#include "tests/core/random_inputs.hpp"
#include "tests/maps/support.hpp"

namespace firstlap::maps {
namespace {

using testing::distance;
using testing::Drive;

const sim::Track& wavy() {
  static const sim::Track track = sim::testing::wavy_track();
  return track;
}

Estimate steps(Localiser& localiser, Drive& drive, int count) {
  Estimate estimate;
  for (int i = 0; i < count; ++i) {
    drive.advance();
    estimate = localiser.step(drive.scan(), drive.measured(), Drive::dt);
  }
  return estimate;
}

std::unique_ptr<Localiser> on(const sim::Track& track, std::uint64_t seed = 1) {
  return std::make_unique<Localiser>(testing::field_of_track(track), CarGeometry{}, LocaliserParams{}, seed);
}

TEST(Localiser, follows_a_racing_car_within_centimetres) {
  auto localiser = on(wavy());
  Drive drive(wavy(), 5.0);
  localiser->start(drive.pose());
  steps(*localiser, drive, 10);
  for (int i = 0; i < 300; ++i) {
    const Estimate estimate = steps(*localiser, drive, 1);
    ASSERT_FALSE(estimate.lost) << i;
    ASSERT_LT(distance(estimate.pose, drive.pose()), 0.10) << i;
    ASSERT_LT(std::abs(wrap_angle(estimate.pose.yaw - drive.pose().yaw)), 0.05) << i;
  }
}

// What becomes of commands is believed more slowly: until then the car is told to drive less, never more.
TEST(Localiser, finds_what_the_measured_speed_is_wrong_by_soon_and_what_the_command_is_later) {
  for (const double error : {-0.15, 0.0, 0.15}) {
    auto localiser = on(wavy());
    Drive drive(wavy(), 5.0);
    localiser->start(drive.pose());
    Estimate estimate;
    for (int i = 0; i < 200; ++i) {
      drive.advance();
      VehicleState state = drive.measured();
      state.speed *= 1.0 + error;
      estimate = localiser->step(drive.scan(), state, Drive::dt);
      localiser->commanded(5.0);
      ASSERT_TRUE(i <= 60 || std::abs(estimate.speed_scale - 1.0 / (1.0 + error)) < 0.03) << error << i;
      ASSERT_GE(estimate.command_scale, 1.0) << error << ' ' << i;
    }
    EXPECT_FALSE(estimate.lost) << error;
    EXPECT_NEAR(estimate.command_scale, 1.0, 0.02) << error;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.10) << error;
  }
}

TEST(Localiser, believes_every_speed_where_its_limit_is_0) {
  LocaliserParams params;
  params.speed_scale.scale_limit = 0.0;
  Localiser localiser(testing::field_of_track(wavy()), CarGeometry{}, params, 1);
  Drive drive(wavy(), 5.0);
  localiser.start(drive.pose());
  for (int i = 0; i < 60; ++i) {
    drive.advance();
    VehicleState state = drive.measured();
    state.speed *= 1.15;
    EXPECT_EQ(localiser.step(drive.scan(), state, Drive::dt).speed_scale, 1.0);
  }
}

TEST(Localiser, finds_itself_from_a_start_that_is_two_metres_and_45_degrees_wrong) {
  for (int i = 0; i < 8; ++i) {
    auto localiser = on(wavy(), static_cast<std::uint64_t>(i) + 1);
    Drive drive(wavy(), 3.0, static_cast<std::uint64_t>(i) + 1);
    const Pose2 truth = drive.pose();
    const double direction = 0.785 * i;
    localiser->start({truth.x + 2.0 * std::cos(direction), truth.y + 2.0 * std::sin(direction),
                      truth.yaw + (i % 2 == 0 ? 0.785 : -0.785)});
    const Estimate estimate = steps(*localiser, drive, 80);
    EXPECT_FALSE(estimate.lost) << i;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.15) << i;
  }
}

TEST(Localiser, recovers_when_the_car_is_set_down_half_a_metre_elsewhere) {
  for (int i = 0; i < 6; ++i) {
    auto localiser = on(wavy());
    Drive drive(wavy(), 3.0);
    localiser->start(drive.pose());
    steps(*localiser, drive, 20 + 15 * i);
    localiser->displace({0.5 * std::cos(1.05 * i), 0.5 * std::sin(1.05 * i), 0.0});
    const Estimate estimate = steps(*localiser, drive, 80);
    EXPECT_FALSE(estimate.lost) << i;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.15) << i;
  }
}

TEST(Localiser, on_a_map_of_another_track_it_is_lost) {
  const sim::Track other = sim::testing::wavy_track(400, 0.9, -0.35);
  auto localiser = on(other);
  Drive drive(wavy(), 3.0);
  localiser->start(drive.pose());
  int lost = 0;
  for (int i = 0; i < 200; ++i) lost += steps(*localiser, drive, 1).lost;
  EXPECT_GT(lost, 150);
}

TEST(Localiser, says_that_it_is_lost_before_it_was_started_and_soon_after_it_goes_blind) {
  auto localiser = on(wavy());
  Drive drive(wavy(), 3.0);
  EXPECT_TRUE(steps(*localiser, drive, 5).lost);
  localiser->start(drive.pose());
  EXPECT_FALSE(steps(*localiser, drive, 20).lost);
  const std::vector<float> nothing(1081, std::numeric_limits<float>::infinity());
  LaserScan blind = drive.scan();
  blind.ranges = nothing;
  int blind_scans = 0;
  while (!localiser->step(blind, {3.0, 0.0, 0.0}, Drive::dt).lost && blind_scans < 100) ++blind_scans;
  EXPECT_GT(blind_scans, 1) << "one lost scan is nothing";
  EXPECT_LT(blind_scans * Drive::dt, 0.3);
}

TEST(Localiser, a_sweep_longer_than_the_usual_period_is_not_undone_even_after_a_lost_scan) {
  constexpr double period = 0.1, sweep = 0.15;
  const auto last_of = [&](double time) {
    auto localiser = on(wavy());
    Drive drive(wavy(), 2.0);
    localiser->start(drive.pose());
    LaserScan scan = drive.scan();
    scan.time_increment = time / static_cast<double>(scan.ranges.size() - 1);
    for (int i = 0; i < 10; ++i) localiser->step(scan, {}, period);
    return localiser->step(scan, {2.0, 0.5, 0.0}, 2.0 * period);
  };
  const Estimate with = last_of(sweep), without = last_of(0.0);
  EXPECT_EQ(with.pose.x, without.pose.x);
  EXPECT_EQ(with.pose.yaw, without.pose.yaw);
  EXPECT_EQ(with.fit, without.fit);
}

TEST(Localiser, the_same_seed_gives_the_same_poses_and_another_seed_others) {
  const auto drive = [](std::uint64_t seed) {
    auto localiser = on(wavy(), seed);
    Drive car(wavy(), 4.0);
    localiser->start(car.pose());
    return steps(*localiser, car, 40);
  };
  const Estimate first = drive(3), again = drive(3), other = drive(4);
  EXPECT_EQ(first.pose.x, again.pose.x);
  EXPECT_EQ(first.pose.yaw, again.pose.yaw);
  EXPECT_EQ(first.std, again.std);
  EXPECT_NE(first.std, other.std);
}

TEST(Localiser, any_input_gives_a_finite_pose) {
  scene::RandomInputs random(scene::seed_or(12));
  auto localiser = on(wavy());
  localiser->start({8.0, 1.0, 1.0});
  for (int i = 0; i < 300; ++i) {
    const auto scan = random.scan();
    const Estimate estimate = localiser->step(scan.view(), random.state(), random.dt());
    ASSERT_TRUE(std::isfinite(estimate.pose.x) && std::isfinite(estimate.pose.y) && std::isfinite(estimate.pose.yaw));
    ASSERT_TRUE(estimate.fit >= 0.0 && estimate.fit <= 1.0);
  }
}

TEST(Localiser, a_step_allocates_nothing_when_found_when_lost_and_on_any_scan) {
  auto localiser = on(wavy());
  Drive drive(wavy(), 4.0);
  scene::RandomInputs random(scene::seed_or(9));
  localiser->start(drive.pose());
  scene::allocations = 0;
  int found = 0;
  for (int i = 0; i < 150; ++i) {
    drive.advance();
    const LaserScan seen = drive.scan();
    const VehicleState state = drive.measured();
    const auto other = random.scan();
    if (i == 60) localiser->displace({2.0, 0.0, 0.5});
    scene::counting = true;
    found += !localiser->step(i < 100 ? seen : other.view(), state, Drive::dt).lost;
    scene::counting = false;
  }
  EXPECT_EQ(scene::allocations, 0);
  EXPECT_GT(found, 40);
}

TEST(Localiser, a_parameter_out_of_range_is_named) {
  LocaliserParams params;
  params.filter.particles_min = 3000;
  params.filter.particles_max = 2000;
  try {
    const Localiser localiser(testing::field_of_track(wavy()), {}, params, 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("filter.particles_min"), std::string::npos) << error.what();
  }
}

TEST(Predicted, goes_round_a_circle) {
  MotionParams motion;
  motion.slip = 0.0;
  const Pose2 quarter = predicted({0, 0, 0}, {1.0, 0.1, 0.0}, motion, 0.5);
  EXPECT_NEAR(quarter.x, std::sin(0.05) / 0.1, 1e-3);
  EXPECT_NEAR(quarter.y, (1.0 - std::cos(0.05)) / 0.1, 1e-3);
  EXPECT_NEAR(quarter.yaw, 0.05, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(predicted({1, 2, 0.5}, {nan, 0.0, 0.0}, motion, 0.5).x, 1.0);
}

TEST(Predicted, slips_outwards_in_a_bend) {
  const Pose2 left = predicted({0, 0, 0}, {4.0, 1.0, 0.0}, {}, 0.1);
  MotionParams none;
  none.slip = 0.0;
  EXPECT_LT(left.y, predicted({0, 0, 0}, {4.0, 1.0, 0.0}, none, 0.1).y);
}

}  // namespace
}  // namespace firstlap::maps
