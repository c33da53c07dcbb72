#include "firstlap/sim/obstacle.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "firstlap/drivers/racer.hpp"
#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

using testing::annulus;
using testing::FixedDriver;
using testing::quiet;
using testing::wavy_track;

constexpr float inf = std::numeric_limits<float>::infinity();

// A straight of 60 m along x, 4 m wide, driven straight on; base_link starts at x = 0.
Track straight() {
  return {Walls({{-20, -2, 60, -2}, {60, -2, 60, 2}, {60, 2, -20, 2}, {-20, 2, -20, -2}}),
          {{0, 0}, {20, 0}, {40, 0}, {40, 1}, {-10, 1}, {-10, 0}}};
}

double ahead(const Race& race) { return static_cast<double>(race.scan().ranges[race.scan().ranges.size() / 2]); }

TEST(Obstacle, appears_at_the_given_distance) {
  const Track track = straight();
  const Car car = quiet(default_car());
  FixedDriver driver({2.0, 0.0});
  Race race(track, car, driver, {.obstacle_sight = 3.0, .obstacle_at = 10.0});
  const double nose = car.geometry.length - car.geometry.rear_overhang;
  while (race.advance()) {
    const double gap = 10.0 - 0.1 - race.pose().x - nose;
    ASSERT_EQ(race.result().obstacle.has_value(), gap <= 3.0 + 1e-9) << gap;
    const double wall = 60.0 - race.pose().x - car.geometry.laser_x;
    const double box = 9.9 - race.pose().x - car.geometry.laser_x;
    if (gap > 3.0) {
      ASSERT_GT(ahead(race), std::min(wall, 29.0) - 0.1);
    }
    if (gap < 2.9) {
      ASSERT_NEAR(ahead(race), box, 0.1);
    }
  }
  EXPECT_NEAR(race.result().obstacle->speed, 2.0, 0.01);
}

TEST(Obstacle, is_hit_by_a_blind_driver_only_where_it_is) {
  const Track track = straight();
  const Car car = quiet(default_car());
  FixedDriver driver({3.0, 0.0});
  const RaceResult hit = run(track, car, driver, {.obstacle_sight = 5.0, .obstacle_at = 12.0});
  ASSERT_EQ(hit.outcome, Outcome::contact);
  EXPECT_TRUE(hit.contact->obstacle);
  EXPECT_EQ(hit.obstacle->clearance, 0.0);
  EXPECT_NEAR(hit.contact->x, 11.9, 0.01);
  const double beside = 0.5 * (car.geometry.width + 0.33) + 0.02;
  const RaceResult missed =
      run(track, car, driver, {.obstacle_sight = 5.0, .obstacle_at = 12.0, .obstacle_offset = beside});
  EXPECT_FALSE(missed.contact && missed.contact->obstacle);
  EXPECT_NEAR(missed.obstacle->clearance, 0.02, 1e-3);
}

TEST(Obstacle, without_a_sight_distance_there_is_none) {
  const Track track = straight();
  FixedDriver driver({3.0, 0.0});
  const RaceResult result = run(track, quiet(default_car()), driver, {.obstacle_at = 12.0});
  EXPECT_FALSE(result.obstacle);
  EXPECT_NEAR(result.contact->x, 60.0, 0.05);
  EXPECT_FALSE(result.contact->obstacle);
}

TEST(Obstacle, appears_on_a_later_lap_if_it_is_farther_than_one_lap) {
  const Track track = annulus(5.0, 1.0);
  const double lap = 2.0 * std::numbers::pi * 5.0;
  FixedDriver driver({0.7, std::atan(0.33 / 5.0)});
  const RaceResult result =
      run(track, quiet(default_car()), driver, {.laps = 3, .obstacle_sight = 2.0, .obstacle_at = lap + 10.0});
  ASSERT_EQ(result.outcome, Outcome::contact);
  EXPECT_EQ(result.laps.size(), 1U);
  EXPECT_NEAR(result.contact->s, 10.0, 0.7);
}

// The box and the track in one set of walls give the same scan, bit for bit.
TEST(Obstacle, is_scanned_like_a_wall) {
  const Track track = wavy_track();
  const LidarParams params;
  const Progress progress(track.centerline);
  std::vector<float> got(1081), expected(1081);
  for (int i = 0; i < 40; ++i) {
    const Pose2 middle = progress.pose_at(2.3 * i), laser = progress.pose_at(2.3 * i - 0.4 - 0.15 * i);
    Obstacle box({middle.x, middle.y, middle.yaw + 0.1 * i}, 0.2, 0.33, params);
    std::vector<WallSegment> all(track.walls.segments().begin(), track.walls.segments().end());
    all.insert(all.end(), box.walls().segments().begin(), box.walls().segments().end());
    const Walls together(all);
    Lidar(params, together).scan(laser, expected);
    Lidar(params, track.walls).scan(laser, got);
    box.add_to_scan(laser, 0, 400, got);
    box.add_to_scan(laser, 400, 1081, got);
    for (std::size_t k = 0; k < got.size(); ++k) ASSERT_NEAR(got[k], expected[k], 1e-6) << i << ' ' << k;
  }
}

TEST(Obstacle, a_car_inside_a_large_box_touches_it) {
  const CarGeometry car;
  const Obstacle box({1.0, 2.0, 0.3}, 3.0, 3.0, {});
  EXPECT_TRUE(box.touch(car, {1.0, 2.0, 0.0}));
  EXPECT_EQ(box.clearance(car, {1.0, 2.0, 0.0}), 0.0);
  EXPECT_FALSE(box.touch(car, {4.0, 2.0, 0.0}));
  EXPECT_GT(box.clearance(car, {4.0, 2.0, 0.0}), 0.5);
}

// On the line of the car, visible from two stopping distances: the car passes or stops, without contact.
TEST(Obstacle, the_racer_passes_it_or_stops) {
  const Track track = wavy_track(400, 0.95, 0.15);
  Racer racer{Params{}};
  int passed = 0, seen = 0;
  for (int i = 0; i < 12; ++i) {
    for (const double offset : {-0.3, 0.0, 0.3}) {
      Race race(track, default_car(), racer,
                {.laps = 1,
                 .seed = 3,
                 .start_s = 7.0 * i,
                 .obstacle_sight = 2.5,
                 .obstacle_at = 12.0,
                 .obstacle_offset = offset});
      while (race.advance() && race.result().distance < 16.0) {
      }
      ASSERT_TRUE(race.result().obstacle);
      ASSERT_NE(race.result().outcome, Outcome::contact) << "at " << 7.0 * i + 12.0 << ", offset " << offset;
      ++seen;
      passed += race.result().outcome == Outcome::running;
    }
  }
  EXPECT_GE(passed, seen / 2);
}

TEST(Obstacle, the_racer_stops_for_a_box_across_the_track) {
  const Track track = wavy_track(400, 0.95, 0.15);
  Racer racer{Params{}};
  for (int i = 0; i < 6; ++i) {
    const RaceResult result =
        run(track, default_car(), racer,
            {.laps = 1, .start_s = 13.0 * i, .obstacle_sight = 3.0, .obstacle_at = 12.0, .obstacle_width = 1.6});
    ASSERT_TRUE(result.obstacle);
    EXPECT_EQ(result.outcome, Outcome::stuck) << i;
    EXPECT_GT(result.obstacle->clearance, 0.0) << i;
  }
}

TEST(Obstacle, a_box_that_never_appears_changes_nothing) {
  const Track track = wavy_track(400, 1.2, 0.1);
  testing::CenterDriver driver(3.0);
  const RaceResult a = run(track, default_car(), driver, {.laps = 1});
  const RaceResult b = run(track, default_car(), driver, {.laps = 1, .obstacle_sight = 1.0, .obstacle_at = 1e5});
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.laps.at(0).min_clearance, b.laps.at(0).min_clearance);
}

TEST(LostBlocks, lose_the_given_share_of_beams_in_blocks) {
  LidarParams params;
  params.noise_sigma = params.dropout_rate = 0.0;
  params.dropout_block_beams = 40;
  const Walls none;
  std::vector<float> ranges(1081);
  for (const double share : {0.1, 0.3, 0.6}) {
    params.dropout_block_share = share;
    const Lidar lidar(params, none);
    Rng rng(3);
    double lost = 0.0, ends = 0.0, first_lost = 0.0;
    constexpr int scans = 2000;
    for (int i = 0; i < scans; ++i) {
      std::fill(ranges.begin(), ranges.end(), 1.0F);
      lidar.add_noise(ranges, rng);
      first_lost += ranges[0] == inf;
      for (std::size_t k = 0; k < ranges.size(); ++k) {
        lost += ranges[k] == inf;
        ends += k > 0 && ranges[k - 1] == inf && ranges[k] != inf;
      }
    }
    EXPECT_NEAR(lost / (scans * 1081.0), share, 0.01);
    EXPECT_NEAR(first_lost / scans, share, 0.04);
    EXPECT_GT(lost / ends, 39.0);
  }
}

}  // namespace
}  // namespace firstlap::sim
