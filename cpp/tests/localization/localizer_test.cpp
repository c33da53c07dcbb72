#include "firstlap/localization/localizer.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <stdexcept>

#include "support/allocations.hpp"
#include "support/mapping_scene.hpp"
#include "support/random_inputs.hpp"

namespace firstlap::localization {
namespace {

using testing::distance;
using testing::Drive;

const sim::Track& wavy() {
  static const sim::Track track = sim::testing::wavy_track();
  return track;
}

Estimate steps(Localizer& localizer, Drive& drive, int count) {
  Estimate estimate;
  for (int i = 0; i < count; ++i) {
    drive.advance();
    estimate = localizer.step(drive.scan(), drive.measured(), Drive::dt);
  }
  return estimate;
}

std::unique_ptr<Localizer> on(const sim::Track& track, std::uint64_t seed = 1) {
  return std::make_unique<Localizer>(testing::field_of_track(track), CarModel{}, LocalizerParams{}, seed);
}

TEST(Localizer, follows_a_racing_car_within_centimeters) {
  auto localizer = on(wavy());
  Drive drive(wavy(), 5.0);
  localizer->start(drive.pose());
  steps(*localizer, drive, 10);
  for (int i = 0; i < 300; ++i) {
    const Estimate estimate = steps(*localizer, drive, 1);
    ASSERT_FALSE(estimate.lost) << i;
    ASSERT_LT(distance(estimate.pose, drive.pose()), 0.10) << i;
    ASSERT_LT(std::abs(wrap_angle(estimate.pose.yaw - drive.pose().yaw)), 0.05) << i;
  }
}

// The command scale converges more slowly: until then commands are reduced, never increased.
TEST(Localizer, finds_the_error_of_the_measured_speed_soon_and_that_of_the_command_later) {
  for (const double error : {-0.15, 0.0, 0.15}) {
    auto localizer = on(wavy());
    Drive drive(wavy(), 5.0);
    localizer->start(drive.pose());
    Estimate estimate;
    for (int i = 0; i < 200; ++i) {
      drive.advance();
      VehicleState state = drive.measured();
      state.speed *= 1.0 + error;
      estimate = localizer->step(drive.scan(), state, Drive::dt);
      localizer->commanded(5.0);
      ASSERT_TRUE(i <= 60 || std::abs(estimate.speed_scale - 1.0 / (1.0 + error)) < 0.03) << error << i;
      ASSERT_GE(estimate.command_scale, 1.0) << error << ' ' << i;
    }
    EXPECT_FALSE(estimate.lost) << error;
    EXPECT_NEAR(estimate.command_scale, 1.0, 0.02) << error;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.10) << error;
  }
}

TEST(Localizer, does_not_correct_speeds_if_the_limit_is_0) {
  LocalizerParams params;
  params.speed_scale.scale_limit = 0.0;
  Localizer localizer(testing::field_of_track(wavy()), CarModel{}, params, 1);
  Drive drive(wavy(), 5.0);
  localizer.start(drive.pose());
  for (int i = 0; i < 60; ++i) {
    drive.advance();
    VehicleState state = drive.measured();
    state.speed *= 1.15;
    EXPECT_EQ(localizer.step(drive.scan(), state, Drive::dt).speed_scale, 1.0);
  }
}

TEST(Localizer, converges_from_a_start_that_is_two_meters_and_45_degrees_wrong) {
  for (int i = 0; i < 8; ++i) {
    auto localizer = on(wavy(), static_cast<std::uint64_t>(i) + 1);
    Drive drive(wavy(), 3.0, static_cast<std::uint64_t>(i) + 1);
    const Pose2 truth = drive.pose();
    const double direction = 0.785 * i;
    localizer->start({truth.x + 2.0 * std::cos(direction), truth.y + 2.0 * std::sin(direction),
                      truth.yaw + (i % 2 == 0 ? 0.785 : -0.785)});
    const Estimate estimate = steps(*localizer, drive, 80);
    EXPECT_FALSE(estimate.lost) << i;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.15) << i;
  }
}

TEST(Localizer, recovers_after_the_car_is_displaced_by_half_a_meter) {
  for (int i = 0; i < 6; ++i) {
    auto localizer = on(wavy());
    Drive drive(wavy(), 3.0);
    localizer->start(drive.pose());
    steps(*localizer, drive, 20 + 15 * i);
    localizer->displace({0.5 * std::cos(1.05 * i), 0.5 * std::sin(1.05 * i), 0.0});
    const Estimate estimate = steps(*localizer, drive, 80);
    EXPECT_FALSE(estimate.lost) << i;
    EXPECT_LT(distance(estimate.pose, drive.pose()), 0.15) << i;
  }
}

TEST(Localizer, on_a_map_of_another_track_it_is_lost) {
  const sim::Track other = sim::testing::wavy_track(400, 0.9, -0.35);
  auto localizer = on(other);
  Drive drive(wavy(), 3.0);
  localizer->start(drive.pose());
  int lost = 0;
  for (int i = 0; i < 200; ++i) lost += steps(*localizer, drive, 1).lost;
  EXPECT_GT(lost, 150);
}

TEST(Localizer, is_lost_before_its_start_and_soon_after_the_last_usable_scan) {
  auto localizer = on(wavy());
  Drive drive(wavy(), 3.0);
  EXPECT_TRUE(steps(*localizer, drive, 5).lost);
  localizer->start(drive.pose());
  EXPECT_FALSE(steps(*localizer, drive, 20).lost);
  const std::vector<float> nothing(1081, std::numeric_limits<float>::infinity());
  LaserScan blind = drive.scan();
  blind.ranges = nothing;
  int blind_scans = 0;
  while (!localizer->step(blind, {3.0, 0.0, 0.0}, Drive::dt).lost && blind_scans < 100) ++blind_scans;
  EXPECT_GT(blind_scans, 1) << "one lost scan is no problem";
  EXPECT_LT(blind_scans * Drive::dt, 0.3);
}

TEST(Localizer, a_sweep_longer_than_the_usual_period_is_not_deskewed_even_after_a_lost_scan) {
  constexpr double period = 0.1, sweep = 0.15;
  const auto last_of = [&](double time) {
    auto localizer = on(wavy());
    Drive drive(wavy(), 2.0);
    localizer->start(drive.pose());
    LaserScan scan = drive.scan();
    scan.time_increment = time / static_cast<double>(scan.ranges.size() - 1);
    for (int i = 0; i < 10; ++i) localizer->step(scan, {}, period);
    return localizer->step(scan, {2.0, 0.5, 0.0}, 2.0 * period);
  };
  const Estimate with = last_of(sweep), without = last_of(0.0);
  EXPECT_EQ(with.pose.x, without.pose.x);
  EXPECT_EQ(with.pose.yaw, without.pose.yaw);
  EXPECT_EQ(with.fit, without.fit);
}

TEST(Localizer, the_same_seed_gives_the_same_poses_and_another_seed_others) {
  const auto drive = [](std::uint64_t seed) {
    auto localizer = on(wavy(), seed);
    Drive car(wavy(), 4.0);
    localizer->start(car.pose());
    return steps(*localizer, car, 40);
  };
  const Estimate first = drive(3), again = drive(3), other = drive(4);
  EXPECT_EQ(first.pose.x, again.pose.x);
  EXPECT_EQ(first.pose.yaw, again.pose.yaw);
  EXPECT_EQ(first.std, again.std);
  EXPECT_NE(first.std, other.std);
}

TEST(Localizer, any_input_gives_a_finite_pose) {
  scene::RandomInputs random(scene::seed_or(12));
  auto localizer = on(wavy());
  localizer->start({8.0, 1.0, 1.0});
  for (int i = 0; i < 300; ++i) {
    const auto scan = random.scan();
    const Estimate estimate = localizer->step(scan.view(), random.state(), random.dt());
    ASSERT_TRUE(std::isfinite(estimate.pose.x) && std::isfinite(estimate.pose.y) && std::isfinite(estimate.pose.yaw));
    ASSERT_TRUE(estimate.fit >= 0.0 && estimate.fit <= 1.0);
  }
}

TEST(Localizer, a_step_allocates_nothing_whether_localized_or_lost_and_on_any_scan) {
  auto localizer = on(wavy());
  Drive drive(wavy(), 4.0);
  scene::RandomInputs random(scene::seed_or(9));
  localizer->start(drive.pose());
  scene::allocations = 0;
  int found = 0;
  for (int i = 0; i < 150; ++i) {
    drive.advance();
    const LaserScan seen = drive.scan();
    const VehicleState state = drive.measured();
    const auto other = random.scan();
    if (i == 60) localizer->displace({2.0, 0.0, 0.5});
    scene::counting = true;
    found += !localizer->step(i < 100 ? seen : other.view(), state, Drive::dt).lost;
    scene::counting = false;
  }
  EXPECT_EQ(scene::allocations, 0);
  EXPECT_GT(found, 40);
}

TEST(Localizer, a_parameter_out_of_range_is_named) {
  LocalizerParams params;
  params.filter.particles_min = 3000;
  params.filter.particles_max = 2000;
  try {
    const Localizer localizer(testing::field_of_track(wavy()), {}, params, 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("filter.particles_min"), std::string::npos) << error.what();
  }
}

TEST(Predicted, follows_a_circle) {
  MotionParams motion;
  motion.slip = 0.0;
  const Pose2 quarter = predicted({0, 0, 0}, {1.0, 0.1, 0.0}, motion, 0.5);
  EXPECT_NEAR(quarter.x, std::sin(0.05) / 0.1, 1e-3);
  EXPECT_NEAR(quarter.y, (1.0 - std::cos(0.05)) / 0.1, 1e-3);
  EXPECT_NEAR(quarter.yaw, 0.05, 1e-12);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(predicted({1, 2, 0.5}, {nan, 0.0, 0.0}, motion, 0.5).x, 1.0);
}

TEST(Predicted, slips_outward_in_a_curve) {
  const Pose2 left = predicted({0, 0, 0}, {4.0, 1.0, 0.0}, {}, 0.1);
  MotionParams none;
  none.slip = 0.0;
  EXPECT_LT(left.y, predicted({0, 0, 0}, {4.0, 1.0, 0.0}, none, 0.1).y);
}

}  // namespace
}  // namespace firstlap::localization
