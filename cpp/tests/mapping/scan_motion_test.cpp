#include "firstlap/mapping/scan_motion.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/mapping_scene.hpp"

namespace firstlap::mapping {
namespace {

using testing::Camera;

constexpr double period = 0.025;

// Pose of a car that drives an arc from the origin.
Pose2 on_arc(double speed, double yaw_rate, double time) {
  if (yaw_rate == 0.0) return {speed * time, 0.0, 0.0};
  const double radius = speed / yaw_rate, yaw = yaw_rate * time;
  return {radius * std::sin(yaw), radius * (1.0 - std::cos(yaw)), yaw};
}

// All steps of a car on an arc, with a scan every period.
std::vector<ScanStep> drive(const sim::Walls& walls, double speed, double yaw_rate, int scans) {
  Camera camera(walls);
  ScanMotion motion({}, {}, {});
  std::vector<ScanStep> steps;
  for (int i = 0; i < scans; ++i) {
    const auto step = motion.add(camera.scan(on_arc(speed, yaw_rate, period * i)), period * i);
    if (step) steps.push_back(*step);
  }
  return steps;
}

TEST(ScanMotion, measures_speed_and_yaw_rate_in_any_direction) {
  for (const auto& [speed, yaw_rate] : {std::pair{1.0, 0.0}, {-0.8, 0.4}, {2.0, -0.8}, {0.0, 0.0}, {0.0, 0.6}}) {
    double forward = 0.0, turn = 0.0, time = 0.0;
    for (const ScanStep& step : drive(testing::odd_room(), speed, yaw_rate, 40)) {
      EXPECT_GT(step.fit, 0.85);
      EXPECT_GT(step.along, 0.1) << "there are walls ahead and beside";
      forward += step.motion.x;
      turn += step.motion.yaw;
      time += step.end - step.begin;
    }
    EXPECT_NEAR(time, 39 * period, 0.1);
    EXPECT_NEAR(forward / time, speed, 0.03);
    EXPECT_NEAR(turn / time, yaw_rate, 0.01);
  }
}

TEST(ScanMotion, steps_are_contiguous_and_not_shorter_than_the_minimum) {
  const auto steps = drive(testing::odd_room(), 1.0, 0.2, 60);
  ASSERT_GT(steps.size(), 10U);
  for (std::size_t i = 1; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].begin, steps[i - 1].end);
    EXPECT_GT(steps[i].end - steps[i].begin, 0.089);
    EXPECT_LT(steps[i].end - steps[i].begin, 0.13);
  }
}

TEST(ScanMotion, a_featureless_corridor_gives_the_turn_but_not_the_distance) {
  const auto walls = testing::walls_of({{-60, -1}, {60, -1}, {60, 1}, {-60, 1}});
  for (const ScanStep& step : drive(walls, 1.0, 0.0, 20)) {
    EXPECT_LT(step.along, 0.01);
    EXPECT_NEAR(step.motion.yaw, 0.0, 1e-3);
  }
}

TEST(ScanMotion, returns_nothing_after_a_gap_a_step_back_in_time_or_an_invalid_scan) {
  const auto room = testing::odd_room();
  Camera camera(room);
  ScanMotion motion({}, {}, {});
  EXPECT_FALSE(motion.add(camera.scan({}), 5.0));
  EXPECT_FALSE(motion.add(camera.scan({}), 7.0)) << "a gap";
  EXPECT_FALSE(motion.add(camera.scan({}), 6.9)) << "back in time";
  LaserScan bad = camera.scan({});
  bad.angle_increment = 0.0;
  EXPECT_FALSE(motion.add(bad, 7.0));
  EXPECT_TRUE(motion.add(camera.scan({}), 7.0));
  motion.forget();
  EXPECT_FALSE(motion.add(camera.scan({}), 7.1));
}

TEST(ScanMotion, forgets_the_velocity) {
  const auto room = testing::odd_room();
  Camera camera(room);
  ScanMotion used({}, {}, {}), fresh({}, {}, {});
  const auto swept = [&](const Pose2& pose) {
    LaserScan scan = camera.scan(pose);
    scan.time_increment = 0.09 / static_cast<double>(scan.ranges.size());
    return scan;
  };
  for (int i = 0; i < 10; ++i) used.add(swept(on_arc(3.0, 1.0, 0.1 * i)), 0.1 * i);
  used.forget();
  const Pose2 there{0.05, 0.0, 0.02};
  used.add(swept({}), 2.0);
  fresh.add(swept({}), 2.0);
  const auto again = used.add(swept(there), 2.1), first = fresh.add(swept(there), 2.1);
  ASSERT_TRUE(again && first);
  EXPECT_EQ(again->motion.x, first->motion.x);
  EXPECT_EQ(again->motion.yaw, first->motion.yaw);
}

TEST(ScanMotion, does_not_deskew_a_sweep_longer_than_the_period) {
  const auto room = testing::odd_room();
  Camera camera(room);
  ScanMotion with({}, {}, {}), without({}, {}, {});
  for (int i = 0; i < 10; ++i) {
    LaserScan scan = camera.scan(on_arc(2.0, 0.5, 0.1 * i));
    const auto expected = without.add(scan, 0.1 * i);
    scan.time_increment = 0.15 / static_cast<double>(scan.ranges.size() - 1);
    const auto step = with.add(scan, 0.1 * i);
    ASSERT_EQ(step.has_value(), expected.has_value()) << i;
    if (!step) continue;
    EXPECT_EQ(step->motion.x, expected->motion.x) << i;
    EXPECT_EQ(step->motion.yaw, expected->motion.yaw) << i;
  }
}

TEST(ScanMotion, loses_track_after_a_jump_and_recovers) {
  const auto room = testing::odd_room();
  Camera camera(room);
  ScanMotion motion({}, {}, {});
  motion.add(camera.scan({}), 0.0);
  const auto lost = motion.add(camera.scan({3.0, 0.0, 2.0}), 0.1);
  ASSERT_TRUE(lost);
  EXPECT_LT(lost->fit, 0.5);
  const auto found = motion.add(camera.scan({3.02, 0.0, 2.0}), 0.125);
  ASSERT_TRUE(found) << "while lost every scan counts";
  EXPECT_GT(found->fit, 0.9);
  EXPECT_NEAR(std::hypot(found->motion.x, found->motion.y), 0.02, 2e-3);
}

}  // namespace
}  // namespace firstlap::mapping
