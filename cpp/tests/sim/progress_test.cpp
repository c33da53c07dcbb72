#include "firstlap/sim/progress.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

const std::vector<Point2> square{{0, 0}, {4, 0}, {4, 4}, {0, 4}};

TEST(Progress, knows_arc_length_offset_and_side) {
  Progress progress(square);
  EXPECT_DOUBLE_EQ(progress.length(), 16.0);
  progress.reset({1.0, 0.5});
  EXPECT_DOUBLE_EQ(progress.s(), 1.0);
  EXPECT_DOUBLE_EQ(progress.lateral_offset(), 0.5);
  EXPECT_DOUBLE_EQ(progress.locate({5.0, 3.0}).s, 7.0);
  EXPECT_DOUBLE_EQ(progress.locate({5.0, 3.0}).offset, -1.0);
}

TEST(Progress, pose_at_inverts_locate) {
  const auto track = testing::wavy_track();
  const Progress progress(track.centerline);
  for (double s = 0.01; s < progress.length(); s += 0.37) {
    const Pose2 pose = progress.pose_at(s);
    ASSERT_NEAR(progress.locate({pose.x, pose.y}).s, s, 1e-9);
    const Pose2 again = progress.pose_at(s - 3.0 * progress.length());
    ASSERT_NEAR(again.x, pose.x, 1e-9);
  }
}

TEST(Progress, counts_laps_forward_and_back) {
  Progress progress(square);
  progress.reset({0.0, 0.0});
  const auto walk = [&](double from, double to, double step) {
    for (double s = from; step > 0.0 ? s < to : s > to; s += step) {
      const Pose2 p = progress.pose_at(s);
      progress.update({p.x, p.y});
    }
  };
  walk(0.0, 40.0, 0.1);
  EXPECT_NEAR(progress.traveled(), 39.9, 0.11);
  walk(40.0, -5.0, -0.1);
  EXPECT_NEAR(progress.traveled(), -4.9, 0.11);
}

TEST(Progress, locate_near_is_one_update) {
  const auto track = testing::wavy_track();
  Progress progress(track.centerline);
  progress.reset(track.centerline[0]);
  for (double s = 0.0; s < progress.length(); s += 0.3) {
    const Pose2 pose = progress.pose_at(s);
    const Point2 point{pose.x + 0.4 * std::cos(s), pose.y + 0.4 * std::sin(s)};
    const Projection near = progress.locate_near(progress.s(), point);
    progress.update(point);
    ASSERT_DOUBLE_EQ(near.s, progress.s());
    ASSERT_DOUBLE_EQ(near.offset, progress.lateral_offset());
  }
}

// A hairpin with legs 1 m apart: a car 0.6 m off the first leg is closer to the second.
TEST(Progress, never_jumps_to_a_neighboring_part) {
  std::vector<Point2> hairpin;
  for (int i = 0; i <= 100; ++i) hairpin.push_back({0.2 * i, 0.0});
  for (int i = 100; i >= 0; --i) hairpin.push_back({0.2 * i, 1.0});
  Progress progress(hairpin);
  progress.reset({5.0, 0.0});
  for (double x = 5.0; x < 15.0; x += 0.02) progress.update({x, 0.6});
  EXPECT_NEAR(progress.traveled(), 10.0, 0.05);
  EXPECT_NEAR(progress.lateral_offset(), 0.6, 1e-9);
}

TEST(Progress, drops_duplicate_points_and_rejects_too_few) {
  const std::vector<Point2> doubled{{0, 0}, {0, 0}, {4, 0}, {4, 4}, {4, 4}, {0, 4}, {0, 0}};
  EXPECT_DOUBLE_EQ(Progress(doubled).length(), 16.0);
  const std::vector<Point2> two{{0, 0}, {1, 0}, {0, 0}};
  EXPECT_THROW(Progress{two}, std::invalid_argument);
  const std::vector<Point2> broken{{0, 0}, {1, 0}, {NAN, 1}};
  EXPECT_THROW(Progress{broken}, std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
