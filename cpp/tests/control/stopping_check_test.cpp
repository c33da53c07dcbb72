#include "firstlap/control/stopping_check.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap {
namespace {

// A straight path along x from behind the car, sampled every 0.1 m.
Buffer<TrajectoryPoint> straight_path(double length) {
  Buffer<TrajectoryPoint> path(512);
  for (double s = 0.0; s <= length; s += 0.1) path.push({s, s - 0.5, 0.0, 0.0, 0.0, 4.0});
  return path;
}

// Walls 0.9 m to either side of the path; the right one includes a face across the path at `x`.
LocalWalls corridor(double face, double from = -0.2, double to = 0.2) {
  LocalWalls walls;
  for (double x = -2.0; x < 12.0; x += 0.1) {
    walls.left.push(x, 0.9, {}, 0.0F);
    walls.right.push(x, -0.9, {}, 0.0F);
  }
  for (double y = from; y <= to; y += 0.02) walls.right.push(face, y, {}, 0.0F);
  return walls;
}

// A car and its limits, with defaults unless stated otherwise.
struct Believed {
  CarModel car{};
  VelocityProfileParams profile{};
  StoppingCheckParams check{};

  [[nodiscard]] StopLimits limits() const { return {car, profile, check}; }
};

StoppingCheck stop(const LocalWalls& walls, double speed, double wheels = 0.0,
                   StopSteering how = StopSteering::track_path) {
  const VehicleState state{speed, 0.0, wheels};
  return check_stopping({straight_path(9.0), 8, walls, state}, {wheels, 0.075, how}, Believed{}.limits());
}

constexpr double nose_x = 0.455;

TEST(StoppingCheck, in_an_empty_corridor_there_is_no_contact_and_the_clearance_is_that_of_the_sides) {
  const StoppingCheck found = stop(corridor(30.0), 4.0);
  EXPECT_TRUE(found.clear);
  EXPECT_NEAR(found.clearance, 0.9 - 0.155, 0.03);
}

TEST(StoppingCheck, a_face_within_the_stopping_distance_is_a_contact_and_one_beyond_it_is_not) {
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
  Believed believed;
  const auto path = straight_path(9.0);
  const LocalWalls walls = corridor(2.5);
  const VehicleState state{3.0, 0.0, 0.0};
  bool was_clear = false;
  for (double brake = 1.0; brake < 15.0; brake += 0.5) {
    believed.profile.a_brake = brake;
    believed.car.brake_max = 20.0;
    const bool clear = check_stopping({path, 8, walls, state}, {.delay = 0.075}, believed.limits()).clear;
    EXPECT_TRUE(clear || !was_clear) << brake;
    was_clear = clear;
  }
  EXPECT_TRUE(was_clear);
}

TEST(StoppingCheck, a_car_stopped_directly_in_front_of_an_obstacle_must_not_start) {
  EXPECT_FALSE(stop(corridor(nose_x + 0.05), 0.0).clear);
  EXPECT_TRUE(stop(corridor(nose_x + 0.5), 0.0).clear);
}

TEST(StoppingCheck, driving_along_a_near_wall_is_allowed_and_approaching_it_is_not) {
  LocalWalls walls;
  for (double x = -2.0; x < 6.0; x += 0.05) walls.right.push(x, -0.19, {}, 0.0F);
  EXPECT_TRUE(stop(walls, 1.0).clear);
  EXPECT_FALSE(stop(walls, 1.0, -0.2, StopSteering::hold).clear);
}

TEST(StoppingCheck, reports_the_steering_angle_of_the_stop) {
  const LocalWalls walls = corridor(6.0);
  EXPECT_EQ(stop(walls, 2.0, 0.2, StopSteering::straight).steering_angle, 0.0);
  EXPECT_GT(stop(walls, 2.0, 0.2, StopSteering::hold).steering_angle, 0.15);
  EXPECT_NEAR(stop(walls, 2.0, 0.0, StopSteering::track_path).steering_angle, 0.0, 1e-9);
}

TEST(StoppingCheck, is_mirror_symmetric) {
  const LocalWalls right = corridor(1.5, -0.3, 0.05);
  LocalWalls left;
  for (std::size_t i = 0; i < right.right.size(); ++i) left.left.push(right.right.x[i], -right.right.y[i], {}, 0.0F);
  for (std::size_t i = 0; i < right.left.size(); ++i) left.right.push(right.left.x[i], -right.left.y[i], {}, 0.0F);
  for (const StopSteering how : {StopSteering::track_path, StopSteering::hold, StopSteering::straight}) {
    const StoppingCheck a = stop(right, 2.5, 0.1, how), b = stop(left, 2.5, -0.1, how);
    EXPECT_EQ(a.clear, b.clear);
    EXPECT_DOUBLE_EQ(a.distance, b.distance);
    EXPECT_DOUBLE_EQ(a.steering_angle, -b.steering_angle);
  }
}

TEST(StoppingCheck, the_steering_of_a_braking_car_stays_within_the_grip) {
  const Believed believed;
  const double most = believed.check.brake_bend_share * believed.profile.a_y_max;
  for (const double speed : {0.0, 1.0, 2.0, 4.0, 8.0}) {
    const double angle = within_grip(0.4, speed, believed.limits());
    EXPECT_LE(speed * speed * std::tan(angle) / believed.car.wheelbase, most + 1e-9) << speed;
    EXPECT_EQ(within_grip(-0.4, speed, believed.limits()), -angle) << speed;
    EXPECT_EQ(within_grip(0.5 * angle, speed, believed.limits()), 0.5 * angle) << speed;
  }
}

// [m] Distance from the face at which a car at `speed` first brakes.
double braking_distance(const Believed& believed, double speed) {
  const auto path = straight_path(9.0);
  const VehicleState state{speed, 0.0, 0.0};
  for (double face = nose_x + 0.05; face < 9.0; face += 0.02)
    if (!decide_stop({path, 8, corridor(face), state}, 0.0, 0.025, false, believed.limits()).brake) return face;
  return 9.0;
}

TEST(StoppingCheck, a_car_that_brakes_later_or_less_starts_to_brake_earlier) {
  const double usual = braking_distance({}, 3.0);
  Believed late, weak, soft;
  late.car.speed_delay = 0.15;
  weak.car.brake_max = 2.5;
  soft.car.speed_gain = 2.0;
  EXPECT_NEAR(braking_distance(late, 3.0) - usual, 3.0 * (0.15 - late.check.reaction_time), 0.08);
  EXPECT_NEAR(braking_distance(weak, 3.0) - usual, 9.0 / 2.0 * (1.0 / 2.5 - 1.0 / 5.0), 0.15);
  EXPECT_GT(braking_distance(soft, 3.0), usual + 0.1);
}

// The car is steered to the right, toward a wall: it has to turn away from it.
TEST(StoppingCheck, a_car_with_a_slow_or_delayed_servo_turns_away_later) {
  LocalWalls walls;
  for (double x = -2.0; x < 6.0; x += 0.05) walls.right.push(x, -0.42, {}, 0.0F);
  const auto path = straight_path(9.0);
  const VehicleState state{3.0, 0.0, -0.12};
  const auto distance = [&](const Believed& believed) {
    return check_stopping({path, 8, walls, state}, {0.1, 0.2}, believed.limits()).clearance;
  };
  Believed slow, late;
  slow.car.servo_time_constant = 0.3;
  late.car.steering_delay = 0.15;
  EXPECT_LT(distance(slow), distance({}) - 0.02);
  EXPECT_LT(distance(late), distance({}) - 0.02);
}

}  // namespace
}  // namespace firstlap
