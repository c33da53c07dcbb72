#include "firstlap/control/stopping_check.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap {
namespace {

// A straight path along x from behind the car, a sample every 0.1 m.
Buffer<TrajectoryPoint> straight_path(double length) {
  Buffer<TrajectoryPoint> path(512);
  for (double s = 0.0; s <= length; s += 0.1) path.push({s, s - 0.5, 0.0, 0.0, 0.0, 4.0});
  return path;
}

// Walls along the path 0.9 m to either side, and on the right one a face across the path at `x`.
LocalWalls corridor(double face, double from = -0.2, double to = 0.2) {
  LocalWalls walls;
  for (double x = -2.0; x < 12.0; x += 0.1) {
    walls.left.push(x, 0.9, {}, 0.0F);
    walls.right.push(x, -0.9, {}, 0.0F);
  }
  for (double y = from; y <= to; y += 0.02) walls.right.push(face, y, {}, 0.0F);
  return walls;
}

StoppingCheck stop(const LocalWalls& walls, double speed, double wheels = 0.0,
                   StopSteering how = StopSteering::to_path) {
  const CarGeometry car;
  const VehicleState state{speed, 0.0, wheels};
  return check_stopping({straight_path(9.0), 8, walls, state}, {wheels, 0.075, how}, car, {});
}

constexpr double nose_x = 0.455;

TEST(StoppingCheck, in_an_empty_corridor_nothing_is_touched_and_the_clearance_is_that_of_the_sides) {
  const StoppingCheck found = stop(corridor(30.0), 4.0);
  EXPECT_TRUE(found.clear);
  EXPECT_NEAR(found.clearance, 0.9 - 0.155, 0.03);
}

TEST(StoppingCheck, a_face_beyond_the_stopping_distance_is_no_matter_and_one_within_it_is) {
  const VelocityProfileParams params;
  for (const double speed : {1.5, 2.5, 4.0, 5.0}) {
    const double shortest = 0.075 * speed + speed * speed / (2.0 * params.a_brake);
    EXPECT_TRUE(stop(corridor(nose_x + shortest + 0.35), speed).clear) << speed;
    const StoppingCheck found = stop(corridor(nose_x + shortest - 0.05), speed);
    EXPECT_FALSE(found.clear) << speed;
    EXPECT_LE(found.distance, shortest) << speed;
  }
}

TEST(StoppingCheck, more_braking_is_never_worse) {
  const CarGeometry car;
  const auto path = straight_path(9.0);
  const LocalWalls walls = corridor(2.5);
  const VehicleState state{3.0, 0.0, 0.0};
  bool was_clear = false;
  for (double brake = 1.0; brake < 15.0; brake += 0.5) {
    VelocityProfileParams params;
    params.a_brake = brake;
    const bool clear = check_stopping({path, 8, walls, state}, {.delay = 0.075}, car, params).clear;
    EXPECT_TRUE(clear || !was_clear) << brake;
    was_clear = clear;
  }
  EXPECT_TRUE(was_clear);
}

TEST(StoppingCheck, a_car_that_stands_nose_to_nose_with_something_may_not_begin) {
  EXPECT_FALSE(stop(corridor(nose_x + 0.05), 0.0).clear);
  EXPECT_TRUE(stop(corridor(nose_x + 0.5), 0.0).clear);
}

TEST(StoppingCheck, driving_along_something_near_is_allowed_coming_nearer_is_not) {
  LocalWalls walls;
  for (double x = -2.0; x < 6.0; x += 0.05) walls.right.push(x, -0.19, {}, 0.0F);
  EXPECT_TRUE(stop(walls, 1.0).clear);
  EXPECT_FALSE(stop(walls, 1.0, -0.2, StopSteering::kept).clear);
}

TEST(StoppingCheck, says_how_it_held_the_wheels) {
  const LocalWalls walls = corridor(6.0);
  EXPECT_EQ(stop(walls, 2.0, 0.2, StopSteering::straight).wheels, 0.0);
  EXPECT_GT(stop(walls, 2.0, 0.2, StopSteering::kept).wheels, 0.15);
  EXPECT_NEAR(stop(walls, 2.0, 0.0, StopSteering::to_path).wheels, 0.0, 1e-9);
}

TEST(StoppingCheck, is_the_same_in_the_mirror) {
  const LocalWalls right = corridor(1.5, -0.3, 0.05);
  LocalWalls left;
  for (std::size_t i = 0; i < right.right.size(); ++i) left.left.push(right.right.x[i], -right.right.y[i], {}, 0.0F);
  for (std::size_t i = 0; i < right.left.size(); ++i) left.right.push(right.left.x[i], -right.left.y[i], {}, 0.0F);
  for (const StopSteering how : {StopSteering::to_path, StopSteering::kept, StopSteering::straight}) {
    const StoppingCheck a = stop(right, 2.5, 0.1, how), b = stop(left, 2.5, -0.1, how);
    EXPECT_EQ(a.clear, b.clear);
    EXPECT_DOUBLE_EQ(a.distance, b.distance);
    EXPECT_DOUBLE_EQ(a.wheels, -b.wheels);
  }
}

TEST(StoppingCheck, a_braking_car_asks_for_no_more_grip_than_there_is) {
  const CarGeometry car;
  const VelocityProfileParams params;
  for (const double speed : {0.0, 1.0, 2.0, 4.0, 8.0}) {
    const double angle = within_grip(0.4, speed, car, params);
    EXPECT_LE(speed * speed * std::tan(angle) / car.wheelbase, 1.3 * params.a_y_max + 1e-9) << speed;
    EXPECT_EQ(within_grip(-0.4, speed, car, params), -angle) << speed;
    EXPECT_EQ(within_grip(0.5 * angle, speed, car, params), 0.5 * angle) << speed;
  }
}

}  // namespace
}  // namespace firstlap
