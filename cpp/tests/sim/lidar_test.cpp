#include "firstlap/sim/lidar.hpp"

#include <gtest/gtest.h>

#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

using testing::wavy_track;

constexpr double inf = std::numeric_limits<double>::infinity();

double expected_range(const LidarParams& params, const Walls& walls, const Pose2& pose, int beam) {
  const double range = walls.raycast_brute_force(pose, params.angle_min() + beam * params.angle_increment());
  if (range > params.range_max) return inf;
  return range < params.range_min ? -inf : range;
}

bool agree(double a, double b) { return a == b || std::abs(a - b) <= 1e-6; }

// Beams that miss the reference: at end points, the reference on either side of the beam is accepted.
int count_disagreements(const LidarParams& params, const Walls& walls, const Pose2& pose) {
  Lidar lidar(params, walls);
  std::vector<float> ranges(static_cast<std::size_t>(params.beams));
  lidar.scan(pose, ranges);
  int bad = 0;
  for (int i = 0; i < params.beams; ++i) {
    const double got = static_cast<double>(ranges[static_cast<std::size_t>(i)]);
    if (agree(got, expected_range(params, walls, pose, i))) continue;
    const double angle = params.angle_min() + i * params.angle_increment();
    if (agree(got, walls.raycast_brute_force(pose, angle + 1e-12))) continue;
    if (agree(got, walls.raycast_brute_force(pose, angle - 1e-12))) continue;
    ++bad;
  }
  return bad;
}

std::vector<WallSegment> random_segments(Rng& rng, int count, double size, double longest) {
  std::vector<WallSegment> segments;
  for (int i = 0; i < count; ++i) {
    const double x = size * (rng.uniform() - 0.5), y = size * (rng.uniform() - 0.5);
    segments.push_back({x, y, x + longest * (rng.uniform() - 0.5), y + longest * (rng.uniform() - 0.5)});
    if (i % 3 != 0) {  // a polyline of two segments
      const WallSegment& last = segments.back();
      segments.push_back({last.x2, last.y2, last.x2 + rng.uniform() - 0.5, last.y2 + rng.uniform() - 0.5});
    }
  }
  return segments;
}

TEST(Lidar, equals_brute_force_among_random_walls_for_200k_beams) {
  Rng rng(11);
  for (int trial = 0; trial < 200; ++trial) {
    const Walls walls(random_segments(rng, 5 + trial % 60, 40.0, trial % 2 == 0 ? 3.0 : 40.0));
    const Pose2 pose{20.0 * (rng.uniform() - 0.5), 20.0 * (rng.uniform() - 0.5), 7.0 * (rng.uniform() - 0.5)};
    ASSERT_EQ(count_disagreements({}, walls, pose), 0) << "trial " << trial;
  }
}

TEST(Lidar, equals_brute_force_on_a_track) {
  const Track track = wavy_track();
  const Progress progress(track.centerline);
  Rng rng(12);
  for (int trial = 0; trial < 100; ++trial) {
    Pose2 pose = progress.pose_at(progress.length() * rng.uniform());
    pose = {pose.x + rng.uniform() - 0.5, pose.y + rng.uniform() - 0.5, pose.yaw + rng.gaussian()};
    ASSERT_EQ(count_disagreements({}, track.walls, pose), 0) << "trial " << trial;
  }
}

TEST(Lidar, equals_brute_force_for_any_beam_count_and_field_of_view) {
  Rng rng(13);
  for (const int beams : {2, 3, 7, 271, 1080, 10000}) {
    for (const double fov : {0.1, 1.0, 3.0, 4.7, 6.28}) {
      const Walls walls(random_segments(rng, 60, 30.0, 10.0));
      ASSERT_EQ(count_disagreements({.beams = beams, .fov = fov}, walls, {0.0, 0.0, rng.gaussian()}), 0)
          << beams << " beams over " << fov;
    }
  }
}

TEST(Lidar, sees_aligned_walls_without_gaps) {  // beams through corners, walls edge-on
  const Walls room({{-2, -2, 2, -2}, {2, -2, 2, 2}, {2, 2, -2, 2}, {-2, 2, -2, -2}, {1, 0, 1.5, 0}});
  Lidar lidar({.beams = 361, .fov = std::numbers::pi}, room);
  std::vector<float> ranges(361);
  lidar.scan({}, ranges);
  for (int i = 0; i < 361; ++i) {
    const double angle = (i - 180) * std::numbers::pi / 360.0;
    const double expected = 2.0 / std::max(std::abs(std::cos(angle)), std::abs(std::sin(angle)));
    EXPECT_NEAR(ranges[static_cast<std::size_t>(i)], expected, 1e-6) << i;
  }
}

TEST(Lidar, sees_visible_walls_only_and_marks_too_far_and_too_near) {
  const Walls walls({{1, -9, 1, 9, false, true}, {40, -9, 40, 9}, {-0.05, -0.2, -0.05, 0.2}});
  Lidar lidar({.beams = 5, .fov = 6.28}, walls);
  std::vector<float> ranges(5);
  lidar.scan({}, ranges);
  EXPECT_EQ(ranges[2], inf);
  EXPECT_EQ(ranges[0], -inf);
}

TEST(Lidar, without_walls_sees_nothing) {
  const Walls walls;
  Lidar lidar({}, walls);
  std::vector<float> ranges(1081, 1.0F);
  lidar.scan({}, ranges);
  for (const float r : ranges) ASSERT_EQ(r, inf);
}

TEST(Lidar, sectors_from_one_pose_make_the_whole_scan) {
  const Track track = wavy_track();
  const Pose2 pose{track.centerline[5].x, track.centerline[5].y, 1.0};
  Lidar lidar({}, track.walls);
  std::vector<float> whole(1081), parts(1081, -1.0F);
  lidar.scan(pose, whole);
  for (const auto& [first, last] : {std::pair{0, 1}, {1, 300}, {300, 301}, {301, 1000}, {1000, 1081}}) {
    lidar.scan_sector(pose, first, last, parts);
  }
  EXPECT_EQ(whole, parts);
}

TEST(Lidar, noise_has_the_given_sigma_and_dropout_rate) {
  const Walls walls;
  const LidarParams params{.noise_sigma = 0.02, .dropout_rate = 0.01};
  const Lidar lidar(params, walls);
  Rng rng(3);
  double sum = 0.0, squares = 0.0;
  int lost = 0, kept = 0;
  for (int scan = 0; scan < 500; ++scan) {
    std::vector<float> ranges(1081, 5.0F);
    lidar.add_noise(ranges, rng);
    for (const float r : ranges) {
      if (std::isinf(r)) {
        ++lost;
        continue;
      }
      const double error = static_cast<double>(r) - 5.0;
      ++kept;
      sum += error;
      squares += error * error;
    }
  }
  EXPECT_NEAR(sum / kept, 0.0, 1.5e-4);
  EXPECT_NEAR(std::sqrt(squares / kept), 0.02, 1e-4);
  EXPECT_NEAR(static_cast<double>(lost) / (lost + kept), 0.01, 6e-4);
}

TEST(Lidar, loses_blocks_of_beams) {
  const Walls walls;
  const LidarParams params{
      .noise_sigma = 0.0, .dropout_rate = 0.0, .dropout_block_rate = 1.0, .dropout_block_beams = 30};
  const Lidar lidar(params, walls);
  Rng rng(4);
  for (int scan = 0; scan < 100; ++scan) {
    std::vector<float> ranges(1081, 5.0F);
    lidar.add_noise(ranges, rng);
    const auto lost = std::count_if(ranges.begin(), ranges.end(), [](float r) { return std::isinf(r); });
    EXPECT_TRUE(lost == 30 || std::isinf(ranges.back())) << lost;
    EXPECT_LE(lost, 30);
  }
}

TEST(Lidar, loses_every_beam_at_dropout_rate_one) {
  const Walls walls;
  const Lidar lidar({.dropout_rate = 1.0}, walls);
  Rng rng(5);
  std::vector<float> ranges(1081, 5.0F);
  lidar.add_noise(ranges, rng);
  for (const float r : ranges) ASSERT_EQ(r, inf);
}

// Any mounting and reading direction sees the same walls, each beam in its own direction.
TEST(Lidar, equals_brute_force_for_any_mounting_and_first_beam) {
  Rng rng(14);
  const double pi = std::numbers::pi;
  for (const double fov : {4.7, 2.0 * pi * 719.0 / 720.0, 2.0 * pi}) {
    for (const double center : {0.0, pi, -2.0}) {
      for (const bool clockwise : {false, true}) {
        for (const bool upside_down : {false, true}) {
          const LidarParams params{.beams = 720,
                                   .fov = fov,
                                   .center_angle = center,
                                   .clockwise = clockwise,
                                   .yaw = pi * (2.0 * rng.uniform() - 1.0),
                                   .upside_down = upside_down};
          const Walls walls(random_segments(rng, 60, 30.0, 10.0));
          ASSERT_EQ(count_disagreements(params, walls, {0.0, 0.0, rng.gaussian()}), 0)
              << fov << ' ' << center << clockwise << upside_down;
        }
      }
    }
  }
}

TEST(Lidar, sectors_make_the_whole_scan_in_either_direction) {
  const Track track = wavy_track();
  const Pose2 pose{track.centerline[5].x, track.centerline[5].y, 1.0};
  Lidar lidar({.center_angle = 1.0, .clockwise = true}, track.walls);
  std::vector<float> whole(1081), parts(1081, -1.0F);
  lidar.scan(pose, whole);
  for (const auto& [first, last] : {std::pair{0, 1}, {1, 300}, {300, 1081}}) {
    lidar.scan_sector(pose, first, last, parts);
  }
  EXPECT_EQ(whole, parts);
}

TEST(Lidar, includes_its_mounting_in_the_header) {
  const double pi = std::numbers::pi;
  const LidarParams params{
      .beams = 360, .fov = 2.0 * pi * 359.0 / 360.0, .center_angle = pi, .yaw = 0.5, .upside_down = true};
  EXPECT_NEAR(params.own_angle_min(), pi / 360.0, 1e-12);
  EXPECT_GT(params.own_angle_increment(), 0.0);
  EXPECT_NEAR(params.angle_min(), 0.5 - params.own_angle_min(), 1e-12);
  EXPECT_NEAR(params.angle_increment(), -params.own_angle_increment(), 1e-12);
}

TEST(Lidar, varies_its_beam_count_over_the_same_angle) {
  const Track track = wavy_track();
  Lidar lidar({.beams = 455, .beams_vary = 10, .fov = 6.2}, track.walls);
  Rng rng(6);
  std::vector<float> ranges;
  std::size_t fewest = 1000, most = 0;
  for (int i = 0; i < 200; ++i) {
    lidar.begin_scan(rng, ranges);
    fewest = std::min(fewest, ranges.size());
    most = std::max(most, ranges.size());
    const LaserScan scan = lidar.view(ranges);
    EXPECT_NEAR(scan.angle_increment * static_cast<double>(ranges.size() - 1), 6.2, 1e-9);
  }
  EXPECT_EQ(fewest, 445U);
  EXPECT_EQ(most, 455U);
  EXPECT_THROW(Lidar({.beams = 5, .beams_vary = 4}, track.walls), std::invalid_argument);
}

TEST(Lidar, a_sweep_lasts_at_most_one_scan_period) {
  const Track track = wavy_track();
  EXPECT_NO_THROW(Lidar({.rate = 10.0, .sweep_time = 0.1}, track.walls));
  EXPECT_NO_THROW(Lidar({.rate = 7.0, .sweep_time = 0.142857}, track.walls)) << "a rounded period";
  try {
    const Lidar lidar({.rate = 40.0, .sweep_time = 0.05}, track.walls);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "lidar.sweep_time is 0.05, allowed at most one scan period, 1 / lidar.rate, which is 0.025 s");
  }
}

TEST(Lidar, reports_no_return_as_its_ros_driver_does) {
  const Walls walls;
  const auto reported = [&](NoReturn how) {
    const LidarParams params{.no_return = static_cast<int>(how), .noise_sigma = 0.01, .dropout_rate = 0.0};
    Lidar lidar(params, walls);
    Rng rng(7);
    std::vector<float> ranges(1081);
    lidar.scan({}, ranges);
    lidar.add_noise(ranges, rng);
    return ranges[3];
  };
  EXPECT_EQ(reported(NoReturn::infinite), inf);
  EXPECT_TRUE(std::isnan(reported(NoReturn::nan)));
  EXPECT_EQ(reported(NoReturn::zero), 0.0F);
  EXPECT_NEAR(reported(NoReturn::range_max), 30.0, 0.05);
}

TEST(Lidar, scales_its_ranges) {
  const Walls walls({{2.0, -9.0, 2.0, 9.0}});
  Lidar lidar({.beams = 3, .fov = 0.2, .range_scale = 1.05}, walls);
  std::vector<float> ranges(3);
  lidar.scan({}, ranges);
  EXPECT_NEAR(ranges[1], 2.1, 1e-6);
}

TEST(Lidar, rejects_a_parameter_by_name) {
  const Walls walls;
  EXPECT_THROW(Lidar({.beams = 1}, walls), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
