#include "firstlap/drivers/reactive_control.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "support/random_inputs.hpp"

namespace firstlap::drivers {
namespace {

Buffer<Point2> points_of(std::initializer_list<Point2> points) {
  Buffer<Point2> buffer(std::max<std::size_t>(points.size(), 1));
  for (const Point2& p : points) buffer.push(p);
  return buffer;
}

TEST(PlanSpeed, allows_a_stop_within_the_free_distance) {
  SpeedParams p{.v_max = 20.0, .a_x_min = -4.0, .stop_distance = 0.5, .delta_v_max = 10.0, .delta_v_min = -10.0};
  EXPECT_NEAR(plan_speed(2.5, 0.0, {3.0, no_command, 0.025}, p), 4.0, 1e-12);  // v^2 = 2 * 4 * 2
  EXPECT_EQ(plan_speed(0.5, 0.0, {3.0, no_command, 0.025}, p), 0.0);
}

TEST(PlanSpeed, is_limited_by_the_grip_in_a_curve) {
  SpeedParams p{.v_max = 20.0, .a_y_max = 4.0, .delta_v_max = 10.0, .delta_v_min = -10.0};
  EXPECT_NEAR(plan_speed(1e3, 1.0, {2.0, no_command, 0.025}, p), 2.0, 1e-12);
  EXPECT_EQ(plan_speed(1e3, 1.0, {2.0, no_command, 0.025}, p), plan_speed(1e3, -1.0, {2.0, no_command, 0.025}, p));
}

TEST(PlanSpeed, stays_near_the_measured_speed_except_for_a_stop) {
  SpeedParams p;
  EXPECT_NEAR(plan_speed(1e3, 0.0, {1.0, no_command, 0.025}, p), 1.0 + p.delta_v_max, 1e-12);
  EXPECT_NEAR(plan_speed(0.4, 0.0, {4.0, no_command, 0.025}, p), 4.0 + p.delta_v_min, 1e-12);
  EXPECT_EQ(plan_speed(0.0, 0.0, {4.0, no_command, 0.025}, p), 0.0);
}

TEST(PlanSpeed, brakes_as_planned_for_any_measured_speed) {
  const SpeedParams p;
  for (const double measured : {4.0, 4.6, 8.0})
    EXPECT_LE(plan_speed(0.4, 0.0, {measured, 4.0, 0.1}, p), 4.0 + p.a_x_min * 0.1) << measured;
  EXPECT_NEAR(plan_speed(0.4, 0.0, {8.0, 4.0, 0.1}, p), 4.0 + p.a_x_min * 0.1, 1e-12);
}

TEST(WithinGrip, limits_the_steering_angle_to_atan_of_l_ay_over_v_squared) {
  const CarGeometry car;
  const SteeringParams p{.a_y_steer = 6.0};
  EXPECT_NEAR(within_grip(0.4, 5.0, p, car), std::atan(car.wheelbase * 6.0 / 25.0), 1e-12);
  EXPECT_NEAR(within_grip(-0.4, 5.0, p, car), -std::atan(car.wheelbase * 6.0 / 25.0), 1e-12);
  EXPECT_EQ(within_grip(2.0, 0.0, p, car), car.steering_limit);
}

TEST(SmoothSteering, moves_halfway_in_one_step_if_the_time_constant_is_the_step) {
  const CarGeometry car;
  EXPECT_NEAR(smooth_steering(0.1, 0.0, 0.025, 0.025, car), 0.05, 1e-12);
  EXPECT_NEAR(smooth_steering(0.4, 0.0, 0.025, 0.0, car), car.steering_rate * 0.025, 1e-12);
}

TEST(FreeAlongArc, straight_ahead_is_the_distance_from_the_bumper) {
  const CarGeometry car;
  const double front = car.length - car.rear_overhang;
  EXPECT_NEAR(free_along_arc(points_of({{2.0, 0.1}, {1.0, 0.3}}), 0.0, 0.0, 10.0, car), 2.0 - front, 1e-12);
  EXPECT_NEAR(free_along_arc(points_of({{2.0, 0.1}, {1.0, 0.3}}), 0.0, 0.2, 10.0, car), 1.0 - front, 1e-12);
  EXPECT_EQ(free_along_arc(points_of({}), 0.0, 0.0, 10.0, car), 10.0);
}

TEST(FreeAlongArc, points_beside_or_behind_the_car_do_not_count) {
  const CarGeometry car;
  const auto beside = points_of({{0.1, 0.25}, {-1.0, 0.0}, {0.2, -0.3}});
  EXPECT_EQ(free_along_arc(beside, 0.0, 0.0, 5.0, car), 5.0);
  EXPECT_EQ(free_along_arc(points_of({{0.1, -0.25}}), 0.3, 0.0, 5.0, car), 5.0);
}

TEST(FreeAlongArc, more_than_half_a_circle_ahead_is_still_ahead) {
  const CarGeometry car;
  const double front = car.length - car.rear_overhang;
  const double free = free_along_arc(points_of({{-1.0, 1.0}}), 1.0, 0.0, 20.0, car);  // three quarters of a circle
  EXPECT_NEAR(free, 1.5 * std::numbers::pi - std::asin(front), 1e-9);
}

bool inside(const Pose2& pose, const Point2& p, const CarGeometry& car) {
  const double dx = p.x - pose.x;
  const double dy = p.y - pose.y;
  const double x = std::cos(pose.yaw) * dx + std::sin(pose.yaw) * dy;
  const double y = -std::sin(pose.yaw) * dx + std::cos(pose.yaw) * dy;
  return x > 0.0 && x < car.length - car.rear_overhang && std::abs(y) < 0.5 * car.width;
}

// The reference moves the car along its circle in millimeter steps.
TEST(FreeAlongArc, agrees_with_moving_the_car_along_its_circle) {
  const CarGeometry car;
  const std::uint64_t seed = scene::seed_or(5);
  scene::RandomInputs random(seed);
  int hits = 0;
  for (int i = 0; i < scene::count_or(300); ++i) {
    const Point2 p{random.uniform(0.5, 3.0), random.uniform(-2.0, 2.0)};
    const double curvature = random.uniform(-1.3, 1.3);
    double rolled = 2.5;
    for (double s = 0.0; s < 2.5; s += 0.001) {
      const double yaw = curvature * s;
      const Pose2 pose{std::sin(yaw) / curvature, (1.0 - std::cos(yaw)) / curvature, yaw};
      if (!inside(pose, p, car)) continue;
      rolled = s;
      break;
    }
    hits += rolled < 2.5;
    EXPECT_NEAR(free_along_arc(points_of({p}), curvature, 0.0, 2.5, car), rolled, 0.004)
        << scene::how_to_repeat(seed, i) << " at " << p.x << " " << p.y << " curvature " << curvature;
  }
  EXPECT_GT(hits, scene::count_or(300) / 20);
}

TEST(LateralClearance, is_measured_from_the_sides) {
  const CarGeometry car;
  const LateralClearance clearance = lateral_clearance(points_of({{0.2, 0.4}, {0.2, -0.3}, {2.0, 0.1}}), car);
  EXPECT_NEAR(clearance.left, 0.4 - 0.5 * car.width, 1e-12);
  EXPECT_NEAR(clearance.right, 0.3 - 0.5 * car.width, 1e-12);
}

}  // namespace
}  // namespace firstlap::drivers
