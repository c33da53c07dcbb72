#include "firstlap/drivers/disparity_extender.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap::drivers {
namespace {

constexpr VehicleState slow{1.0, 0.0, 0.0};

// A hall with a screen ahead, whose left edge is at (2, y) from the LiDAR.
scene::Scene screen(double y) {
  const double x = 2.0 + CarGeometry{}.laser_x;
  scene::Scene hall;
  hall.add(scene::neither, {{-5, -4}, {9, -4}, {9, 4}, {-5, 4}, {-5, -4}});
  hall.add(scene::neither, {{x, -4}, {x, y}});
  return hall;
}

TEST(DisparityExtender, a_disparity_is_extended_over_half_the_car_and_the_tolerance) {
  DisparityExtenderParams params;
  DisparityExtender driver(params);
  driver.step(screen(0.0).scan({0, 0, 0}).view(), slow, 0.025);
  const auto& trace = driver.trace();
  ASSERT_GE(trace.disparities.size(), 1U);
  const double width = 0.5 * params.car.width + params.disparity.tolerance;
  const double expected = 2.0 * std::asin(0.5 * width / 2.0);
  double covered = 0.0;
  for (std::size_t i = 0; i < trace.extended.size(); ++i)
    if (trace.extended[i] < trace.ranges[i] - 1e-9) covered += trace.beam_step;
  EXPECT_NEAR(covered, expected, 2.0 * trace.beam_step);
}

TEST(DisparityExtender, ranges_shorter_than_the_disparity_stay) {
  DisparityExtender driver(DisparityExtenderParams{});
  driver.step(screen(0.0).scan({0, 0, 0}).view(), slow, 0.025);
  for (std::size_t i = 0; i < driver.trace().extended.size(); ++i)
    EXPECT_LE(driver.trace().extended[i], driver.trace().ranges[i]);
}

TEST(DisparityExtender, aims_at_the_middle_of_the_farthest_block) {
  DisparityExtenderParams params;
  params.scan.range_use = 6.0;
  DisparityExtender driver(params);
  scene::Scene hall;  // open to the left, between a screen and the far left wall
  hall.add(scene::neither, {{-5, -4}, {15, -4}, {15, 3}, {3, 3}, {3, 1.5}, {-5, 1.5}, {-5, -4}});
  driver.step(hall.scan({0, 0, 0}).view(), slow, 0.025);
  const auto& t = driver.trace();
  const double first = t.first_beam + t.beam_step * t.block_first;
  const double last = t.first_beam + t.beam_step * t.block_last;
  EXPECT_NEAR(t.aim, 0.5 * (first + last), 1e-9);
  for (int i = t.block_first; i <= t.block_last; ++i)
    EXPECT_GE(t.extended[static_cast<std::size_t>(i)], params.disparity.block_share * 6.0 - 1e-9);
  EXPECT_NEAR(t.aim_free, 6.0, 0.2);
}

TEST(DisparityExtender, does_not_turn_toward_a_side_without_clearance) {
  DisparityExtenderParams params;
  params.disparity.side_clearance = 0.2;
  params.disparity.tolerance = 0.0;
  const auto corner = [&](double clearance) {  // the left wall ends beside the car, the track continues on the left
    const double y = 0.5 * params.car.width + clearance;
    scene::Scene scene;
    scene.add(scene::right, {{-9, -1}, {2.5, -1}, {2.5, 9}});
    scene.add(scene::left, {{-9, y}, {0.2, y}, {0.2, 9}});
    return scene.scan({0, 0, 0});
  };
  DisparityExtender driver(params);
  const StepResult held = driver.step(corner(0.1).view(), slow, 0.025);
  EXPECT_TRUE(driver.trace().held_left);
  EXPECT_GT(driver.trace().wanted, 0.05);
  EXPECT_EQ(held.command.steering_angle, 0.0);
  driver.reset();
  EXPECT_GT(driver.step(corner(0.3).view(), slow, 0.025).command.steering_angle, 0.0);
}

TEST(DisparityExtender, the_speed_depends_on_the_free_distance) {
  DisparityExtenderParams params;
  params.speed.delta_v_min = -10.0;
  params.speed.delta_v_max = 10.0;
  params.speed.v_max = 20.0;
  DisparityExtender driver(params);
  const scene::Scene corridor = scene::Course{}.straight(60).walls(2.0);
  const StepResult result = driver.step(corridor.scan({5, 0, 0}).view(), {5.0, 0, 0}, 0.025);
  const double expected = std::sqrt(-2.0 * params.speed.a_x_min * (params.scan.range_use - params.speed.stop_distance));
  EXPECT_NEAR(result.command.speed, expected, 0.3);
}

}  // namespace
}  // namespace firstlap::drivers
