#include "firstlap/drivers/follow_the_gap.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap::drivers {
namespace {

constexpr VehicleState slow{1.0, 0.0, 0.0};

// A wall at x = 3 with an opening around `y`, in a wide hall.
scene::Scene opening(double y, double width) {
  scene::Scene hall;
  hall.add(scene::neither, {{-5, -4}, {15, -4}, {15, 4}, {-5, 4}, {-5, -4}});
  hall.add(scene::neither, {{3, -4}, {3, y - 0.5 * width}});
  hall.add(scene::neither, {{3, y + 0.5 * width}, {3, 4}});
  return hall;
}

TEST(FollowTheGap, aims_at_the_middle_of_the_only_gap) {
  FollowTheGapParams params;
  params.gap.free_distance = 5.0;
  params.gap.center_weight = 1.0;
  FollowTheGap driver(params);
  driver.step(opening(1.0, 1.6).scan({0, 0, 0}).view(), slow, 0.025);
  const double x = 3.0 - params.car.laser_x;
  EXPECT_NEAR(driver.trace().aim, std::atan2(1.0, x), 0.03);
  EXPECT_GT(driver.trace().aim_free, 5.0);
}

TEST(FollowTheGap, a_gap_too_narrow_for_the_car_is_not_free) {
  FollowTheGapParams params;
  params.gap.free_distance = 5.0;
  params.gap.body_margin = 0.05;
  params.gap.bubble_radius = 0.0;
  const double needed = params.car.width + 2.0 * params.gap.body_margin;
  FollowTheGap driver(params);
  driver.step(opening(0.0, needed - 0.05).scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_LT(driver.trace().threshold, 5.0);
  driver.step(opening(0.0, needed + 0.1).scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_EQ(driver.trace().threshold, 5.0);
  EXPECT_NEAR(driver.trace().aim, 0.0, 0.02);
}

TEST(FollowTheGap, free_distance_is_that_of_a_disc_of_the_cars_width) {
  FollowTheGapParams params;
  params.gap.bubble_radius = 0.0;
  FollowTheGap driver(params);
  scene::Scene wall;
  wall.add(scene::neither, {{4, -9}, {4, 9}, {-9, 9}, {-9, -9}, {4, -9}});
  driver.step(wall.scan({0, 0, 0}).view(), slow, 0.025);
  const double radius = 0.5 * params.car.width + params.gap.body_margin;
  const double expected = 4.0 - params.car.laser_x - radius;
  const auto& free = driver.trace().free;
  EXPECT_NEAR(free[FollowTheGap::directions_per_side], expected, 2e-3);
  const std::size_t k = FollowTheGap::directions_per_side + 90;
  const double angle = 90 * driver.trace().step;
  EXPECT_NEAR(free[k], expected / std::cos(angle), 5e-3);
}

TEST(FollowTheGap, nothing_within_the_bubble_of_the_nearest_return_is_free) {
  FollowTheGapParams params;
  params.gap.bubble_radius = 0.5;
  FollowTheGap driver(params);
  const scene::Scene track = scene::Course{}.straight(30).walls(3.0);
  driver.step(track.scan({10, -0.6, 0}).view(), slow, 0.025);
  EXPECT_NEAR(driver.trace().nearest.y, -0.9, 0.05);
  const double half = std::asin(0.5 / 0.9);
  for (int k = -FollowTheGap::directions_per_side; k <= 0; ++k) {
    const double angle = k * driver.trace().step;
    if (angle > -params.gap.view_angle + half - 0.1) continue;
    EXPECT_EQ(driver.trace().free[static_cast<std::size_t>(k + FollowTheGap::directions_per_side)], 0.0) << angle;
  }
}

// A post is where the wanted arc would sweep it: another arc is chosen.
TEST(FollowTheGap, chooses_an_arc_that_the_body_can_sweep) {
  FollowTheGapParams params;
  params.steering.steering_gain = 2.0;
  params.gap.free_distance = 5.0;
  params.gap.arc_distance = 2.0;
  params.gap.bubble_radius = 0.1;
  FollowTheGap driver(params);
  scene::Scene hall = opening(1.5, 2.0);
  hall.box(scene::neither, 0.55, 0.57, 0.1, 0.1);
  driver.step(hall.scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_NE(driver.trace().arc, driver.trace().wanted);
  EXPECT_GT(driver.trace().arc_free, 1.0);
  params.gap.arc_distance = params.gap.arc_time = 0.0;
  FollowTheGap blind(params);
  blind.step(hall.scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_EQ(blind.trace().arc, blind.trace().wanted);
  EXPECT_LT(blind.trace().arc_free, 0.5);
}

TEST(FollowTheGap, of_two_equal_gaps_the_straighter_one_is_chosen) {
  FollowTheGapParams params;
  params.gap.free_distance = 4.5;
  params.gap.run_power = 0.0;
  FollowTheGap driver(params);
  scene::Scene hall;
  hall.add(scene::neither, {{-5, -6}, {15, -6}, {15, 6}, {-5, 6}, {-5, -6}});
  hall.add(scene::neither, {{3, -6}, {3, -3.2}});
  hall.add(scene::neither, {{3, -1.4}, {3, -0.4}});
  hall.add(scene::neither, {{3, 1.4}, {3, 6}});
  driver.step(hall.scan({0, 0, 0}).view(), slow, 0.025);
  EXPECT_NEAR(driver.trace().aim, std::atan2(0.5, 3.0 - params.car.laser_x), 0.15);
}

}  // namespace
}  // namespace firstlap::drivers
