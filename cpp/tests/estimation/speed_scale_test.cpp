#include "firstlap/estimation/speed_scale.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "firstlap/drivers/racer.hpp"
#include "support/scene.hpp"

namespace firstlap {
namespace {

// A corridor that turns right before a wall ahead, as samples in base_link, `x` meters along it.
void add_wall(double x, Point2 from, Point2 to, int vote, WallSide& side, Buffer<SectionSample>& samples) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  for (double s = 0.0; s < length; s += 0.15) {
    const Point2 p{from.x + s / length * (to.x - from.x) - x, from.y + s / length * (to.y - from.y)};
    side.push(p.x, p.y, {}, 0.0F);
    samples.push({.x = p.x, .y = p.y, .section = 0, .vote = vote});
  }
  side.seen = side.size();
}

struct Seen {
  Seen(double x, bool open) : samples(max_samples) {
    add_wall(x, {-2, 1}, {8, 1}, 1, walls.left, samples);
    if (!open) add_wall(x, {8, 1}, {8, -6}, 1, walls.left, samples);
    add_wall(x, {6, -6}, {6, -1}, -1, walls.right, samples);
    add_wall(x, {6, -1}, {-2, -1}, -1, walls.right, samples);
  }
  LocalWalls walls;
  Buffer<SectionSample> samples;
};

TEST(ForwardError, is_the_motion_of_the_walls_minus_odometry) {
  for (const double missed : {-0.03, -0.01, 0.0, 0.01, 0.03}) {
    const Seen before(0.0, false);
    const Seen now(missed, false);
    const MotionError error = forward_error(before.walls, now.samples, 0.15, {});
    EXPECT_NEAR(error.forward, missed, 0.002) << missed;
    EXPECT_GT(error.information, 1e4);
  }
}

TEST(ForwardError, has_no_information_between_parallel_walls) {
  LocalWalls walls;
  Buffer<SectionSample> now(max_samples);
  add_wall(0.0, {-2, 1}, {8, 1}, 1, walls.left, now);
  add_wall(0.0, {-2, -1}, {8, -1}, -1, walls.right, now);
  EXPECT_LT(forward_error(walls, now, 0.15, {}).information, 1.0);
  EXPECT_EQ(forward_error({}, now, 0.15, {}).information, 0.0);
}

TEST(ForwardError, searches_along_a_wall_and_globally_if_that_ends_far_away) {
  WallSide side;
  for (int i = 0; i < 40; ++i) side.push(0.15 * i, 1.0, {}, 0.0F);
  for (int i = 0; i < 40; ++i) side.push(6.0 - 0.15 * i, 3.0, {}, 0.0F);
  WallSearch search(side, side.size());
  EXPECT_EQ(search.nearest_onwards(3.0, 1.1, 0.3).index, 20U);
  EXPECT_EQ(search.nearest_onwards(1.5, 1.1, 0.3).index, 10U);
  EXPECT_EQ(search.nearest_onwards(3.0, 2.9, 0.3).index, 60U) << "across";
  EXPECT_EQ(search.nearest_onwards(3.3, 2.9, 0.3).index, 58U);
  EXPECT_GT(search.nearest_onwards(3.3, 9.0, 0.3).distance, 0.3);
  EXPECT_GT(WallSearch(side, 0).nearest_onwards(0.0, 0.0, 0.3).distance, 1e9);
}

SpeedScale after(double seconds, double true_speed, double measured, double command) {
  const SpeedScaleParams params;
  SpeedScale scale;
  const double dt = 0.025;
  for (double t = 0.0; t < seconds; t += dt) {
    expect_speed(command, dt, CarDynamics{}, scale);
    learn_from_command(measured, dt, params, scale);
    const double assumed = measured * measured_speed_scale(scale, params);
    learn_from_walls({(true_speed - assumed) * dt, 1e6}, {assumed * dt, measured * dt, dt}, params, scale);
  }
  return scale;
}

TEST(SpeedScale, finds_the_error_of_the_measured_speed_within_a_second) {
  const SpeedScaleParams params;
  for (const double error : {-0.15, -0.1, 0.1, 0.15})
    EXPECT_NEAR(measured_speed_scale(after(1.0, 4.0, 4.0 * (1.0 + error), 4.0), params), 1.0 / (1.0 + error), 0.01);
}

TEST(SpeedScale, is_exactly_one_without_an_error) {
  const SpeedScaleParams params;
  for (const double error : {-0.01, 0.0, 0.01}) {
    const SpeedScale scale = after(5.0, 4.0, 4.0 * (1.0 + error), 4.0);
    EXPECT_EQ(measured_speed_scale(scale, params), 1.0);
    EXPECT_EQ(command_speed_scale(scale, params), 1.0);
  }
}

TEST(SpeedScale, distinguishes_a_car_faster_than_commanded_from_an_overestimated_speed) {
  const SpeedScaleParams params;
  EXPECT_NEAR(command_speed_scale(after(8.0, 4.6, 4.0, 4.0), params), 1.15, 0.02);
  EXPECT_EQ(command_speed_scale(after(8.0, 4.0, 4.6, 4.0), params), 1.0);
  EXPECT_EQ(command_speed_scale(after(8.0, 3.4, 4.0, 4.0), params), 1.0) << "a slow car is not commanded to go faster";
}

TEST(SpeedScale, ignores_a_car_that_is_held_back) {
  const SpeedScaleParams params;
  const SpeedScale scale = after(8.0, 1.5, 1.5, 4.0);
  EXPECT_NEAR(scale.commanded_driven / scale.commanded_square, 1.0, 0.15);
  EXPECT_EQ(command_speed_scale(scale, params), 1.0);
}

// The car's own dynamics tell how long its speed takes: 1 - 1/e of the command after delay and time constant.
TEST(SpeedScale, expects_the_speed_that_the_cars_speed_loop_gives) {
  for (const CarDynamics& car : {CarDynamics{}, CarDynamics{.speed_delay = 0.1, .speed_gain = 4.0}}) {
    const double time = car.speed_delay + 1.0 / car.speed_gain;
    SpeedScale scale;
    constexpr int steps = 100;
    for (int i = 0; i < steps; ++i) expect_speed(4.0, time / steps, car, scale);
    EXPECT_NEAR(scale.expected, 4.0 * (1.0 - std::exp(-1.0)), 1e-9);
  }
}

TEST(SpeedScale, stays_within_its_limit_and_can_be_switched_off) {
  SpeedScaleParams params;
  SpeedScale scale = after(3.0, 8.0, 4.0, 4.0);
  EXPECT_LE(measured_speed_scale(scale, params), 1.0 + params.scale_limit);
  EXPECT_LE(command_speed_scale(scale, params), 1.0 + params.scale_limit);
  params.scale_limit = 0.0;
  EXPECT_EQ(measured_speed_scale(scale, params), 1.0);
  EXPECT_EQ(command_speed_scale(scale, params), 1.0);
}

// A racer on a course, in a car whose measured speed is too high by `error`.
TEST(SpeedScale, is_found_by_a_racer_on_a_course) {
  for (const double error : {-0.15, 0.0, 0.15}) {
    const scene::Course course = scene::Course{}.straight(12).turn(2.0, 1.5).straight(12);
    const scene::Scene walls = course.walls(1.8);
    Racer racer{Params{}};
    for (double s = 1.0; s < 11.0; s += 0.1) {
      racer.step(walls.scan(course.at(s)).view(), {4.0 * (1.0 + error), 0.0, 0.0}, 0.025);
    }
    EXPECT_NEAR(racer.trace().speed_scale, 1.0 / (1.0 + error), 0.03) << error;
  }
}

}  // namespace
}  // namespace firstlap
