#include "firstlap/planning/velocity_profile.hpp"

#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <string>

#include "support/random_inputs.hpp"

namespace firstlap {
namespace {

Buffer<TrajectoryPoint> path_of(std::size_t count, double curvature) {
  Buffer<TrajectoryPoint> path(max_path_points);
  for (std::size_t i = 0; i < count; ++i) path.push({0.1 * static_cast<double>(i), 0.0, 0.0, 0.0, curvature, 0.0});
  return path;
}

// Curvature that changes as on a race track.
Buffer<TrajectoryPoint> random_path(scene::RandomInputs& random) {
  Buffer<TrajectoryPoint> path(max_path_points);
  const int n = random.integer(4, 120);
  double curvature = 0.0;
  double s = 0.0;
  for (int i = 0; i < n; ++i) {
    if (random.chance(0.1)) curvature = random.uniform(-1.5, 1.5);
    path.push({s, s, 0.0, 0.0, curvature, 0.0});
    s += random.uniform(0.05, 0.15);
  }
  return path;
}

VelocityProfileParams random_params(scene::RandomInputs& random) {
  VelocityProfileParams p;
  p.v_min = random.uniform(0.3, 3.0);
  p.v_max = p.v_min + random.uniform(0.0, 8.0);
  p.a_x_max = random.uniform(1.0, 8.0);
  p.a_x_min = -random.uniform(1.0, 8.0);
  p.a_y_max = random.uniform(1.0, 8.0);
  p.v_horizon = random.uniform(0.0, 2.0);
  p.friction_ellipse = random.chance(0.5);
  return p;
}

VelocityProfileParams free_params() {  // only one limit at a time is active
  VelocityProfileParams p;
  p.v_min = 0.3;
  p.v_max = 20.0;
  p.v_horizon = 10.0;
  return p;
}

// Each run's check gets the text to reproduce it; the first failure ends the runs.
template <class Check>
void in_random_runs(std::uint64_t standard_seed, Check check) {
  const auto seed = scene::seed_or(standard_seed);
  scene::RandomInputs random(seed);
  for (int run = 0; run < scene::count_or(2000) && !::testing::Test::HasFatalFailure(); ++run)
    check(random, scene::how_to_repeat(seed, run));
}

TEST(VelocityProfile, in_a_steady_curve_it_is_the_root_of_a_y_times_radius) {
  for (const double radius : {0.5, 1.0, 2.0, 4.0}) {
    VelocityProfileParams p = free_params();
    const double v = std::sqrt(p.a_y_max * radius);
    auto path = path_of(120, -1.0 / radius);
    plan_velocity(v, 5, p, path);
    for (std::size_t i = 5; i < 50; ++i) EXPECT_NEAR(path[i].velocity, v, 1e-12) << radius;
  }
}

TEST(VelocityProfile, from_standstill_it_is_the_root_of_2_a_s) {
  const VelocityProfileParams p = free_params();
  auto path = path_of(120, 0.0);
  plan_velocity(0.0, 0, p, path);
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_NEAR(path[i].velocity, std::sqrt(0.09 + 2.0 * p.a_x_max * path[i].s), 1e-9) << "v_0 is at least 0.3";
}

TEST(VelocityProfile, before_a_curve_it_brakes_with_a_x_min) {
  const VelocityProfileParams p = free_params();
  auto path = path_of(150, 0.0);
  for (std::size_t i = 40; i < 150; ++i) path[i].curvature = 1.0;
  plan_velocity(4.0, 0, p, path);
  const double corner = std::sqrt(p.a_y_max);
  EXPECT_NEAR(path[40].velocity, corner, 1e-9);
  for (std::size_t i = 30; i < 40; ++i)
    EXPECT_NEAR(path[i].velocity, std::sqrt(corner * corner - 2.0 * p.a_x_min * (path[40].s - path[i].s)), 1e-9);
}

TEST(VelocityProfile, it_never_exceeds_v_max_beyond_the_car) {
  VelocityProfileParams p;
  auto path = path_of(120, 0.0);
  plan_velocity(3.0, 2, p, path);
  for (std::size_t i = 3; i < path.size(); ++i) EXPECT_LE(path[i].velocity, p.v_max);
}

TEST(VelocityProfile, v_min_outranks_the_grip_limit_in_a_tight_corner) {
  VelocityProfileParams p;
  auto path = path_of(120, 5.0);
  plan_velocity(2.0, 0, p, path);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_DOUBLE_EQ(path[i].velocity, p.v_min);
}

TEST(VelocityProfile, a_higher_v_max_never_lowers_a_velocity) {
  in_random_runs(1, [](scene::RandomInputs& random, const std::string& repeat) {
    auto low = random_path(random);
    auto high = low;
    VelocityProfileParams p = random_params(random);
    const double speed = random.uniform(0.0, p.v_max);
    const auto from = static_cast<std::size_t>(random.integer(0, static_cast<int>(low.size()) / 2));
    plan_velocity(speed, from, p, low);
    p.v_max += random.uniform(0.0, 5.0);
    plan_velocity(speed, from, p, high);
    // With the friction ellipse a faster car may have less grip left to accelerate, see method.md, rho.
    if (p.friction_ellipse) return;
    for (std::size_t i = 0; i < low.size(); ++i) ASSERT_GE(high[i].velocity, low[i].velocity - 1e-12) << repeat;
  });
}

TEST(VelocityProfile, acceleration_and_braking_stay_within_their_limits_where_v_min_does_not_act) {
  in_random_runs(2, [](scene::RandomInputs& random, const std::string& repeat) {
    auto path = random_path(random);
    const VelocityProfileParams p = random_params(random);
    const auto from = static_cast<std::size_t>(random.integer(0, static_cast<int>(path.size()) / 2));
    plan_velocity(random.uniform(0.0, p.v_max), from, p, path);
    // If the car is faster than the plan at its own position, the limits do not apply to the step to the next point.
    for (std::size_t i = from + 2; i < path.size(); ++i) {
      const double v0 = path[i - 1].velocity;
      const double v1 = path[i].velocity;
      const double a = (v1 * v1 - v0 * v0) / (2.0 * (path[i].s - path[i - 1].s));
      if (v1 > p.v_min + 1e-9) {
        ASSERT_LE(a, p.a_x_max + 1e-6) << repeat << " point " << i;
      }
      if (v0 > p.v_min + 1e-9) {
        ASSERT_GE(a, p.a_x_min - 1e-6) << repeat << " point " << i;
      }
    }
  });
}

TEST(VelocityProfile, lateral_acceleration_stays_within_its_limit_where_v_min_does_not_act) {
  in_random_runs(3, [](scene::RandomInputs& random, const std::string& repeat) {
    auto path = random_path(random);
    const VelocityProfileParams p = random_params(random);
    plan_velocity(random.uniform(0.0, p.v_max), 0, p, path);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const double v = path[i].velocity;
      if (v > p.v_min + 1e-9) {
        ASSERT_LE(v * v * std::abs(path[i].curvature), p.a_y_max + 1e-9) << repeat;
      }
    }
  });
}

TEST(VelocityProfile, with_the_friction_ellipse_no_point_is_faster_than_without) {
  in_random_runs(4, [](scene::RandomInputs& random, const std::string& repeat) {
    auto circle = random_path(random);
    auto ellipse = circle;
    VelocityProfileParams p = random_params(random);
    const double speed = random.uniform(0.0, p.v_max);
    p.friction_ellipse = false;
    plan_velocity(speed, 0, p, circle);
    p.friction_ellipse = true;
    plan_velocity(speed, 0, p, ellipse);
    for (std::size_t i = 0; i < circle.size(); ++i)
      ASSERT_LE(ellipse[i].velocity, circle[i].velocity + 1e-12) << repeat;
  });
}

TEST(VelocityProfile, the_friction_ellipse_leaves_the_root_of_one_minus_the_squared_share_of_cornering) {
  VelocityProfileParams p = free_params();
  p.friction_ellipse = true;
  constexpr double speed = 1.5;
  constexpr double curvature = 0.5;
  auto path = path_of(120, curvature);
  plan_velocity(speed, 0, p, path);
  const double cornering = speed * speed * curvature / p.a_y_max;  // 0.49
  const double a = p.a_x_max * std::sqrt(1.0 - cornering * cornering);
  EXPECT_NEAR(path[1].velocity, std::sqrt(speed * speed + 2.0 * 0.1 * a), 1e-9);
}

TEST(VelocityProfile, at_the_end_of_the_visible_track_it_can_always_be_at_the_horizon_speed) {
  in_random_runs(5, [](scene::RandomInputs& random, const std::string& repeat) {
    auto path = random_path(random);
    const VelocityProfileParams p = random_params(random);
    plan_velocity(random.uniform(0.0, p.v_max), 0, p, path);
    for (const TrajectoryPoint& q : path)
      ASSERT_LE(q.velocity, std::sqrt(p.v_horizon * p.v_horizon - 2.0 * p.a_x_min * (path.back().s - q.s)) + 1e-9)
          << repeat;
  });
}

TEST(VelocityProfile, before_the_end_it_never_falls_below_v_min) {
  in_random_runs(6, [](scene::RandomInputs& random, const std::string& repeat) {
    auto path = random_path(random);
    const VelocityProfileParams p = random_params(random);
    plan_velocity(random.uniform(0.0, p.v_max), 0, p, path);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const double left = path.back().s - path[i].s;
      const double end = std::sqrt(p.v_horizon * p.v_horizon - 2.0 * p.a_x_min * left);
      ASSERT_GE(path[i].velocity, std::min(p.v_min, end) - 1e-9) << repeat;
    }
  });
}

TEST(VelocityProfile, a_stop_is_exempt_from_v_min) {
  const VelocityProfileParams p;
  auto path = path_of(80, 0.0);
  plan_velocity(3.0, 0, p, path);
  stop_before(2.0, p, path);
  for (const TrajectoryPoint& q : path) {
    if (q.s >= 2.0) {
      EXPECT_EQ(q.velocity, 0.0);
    } else {
      EXPECT_LE(q.velocity, std::sqrt(-2.0 * p.a_x_min * (2.0 - q.s)) + 1e-12);
    }
  }
}

TEST(VelocityProfile, an_empty_path_and_a_start_beyond_its_end_are_handled) {
  Buffer<TrajectoryPoint> path(8);
  plan_velocity(3.0, 0, {}, path);
  path = path_of(4, 0.0);
  plan_velocity(3.0, 9, {}, path);
  for (const TrajectoryPoint& q : path) EXPECT_TRUE(std::isfinite(q.velocity));
}

TEST(CommandSpeed, it_changes_by_at_most_the_two_deltas) {
  const VelocityProfileParams p;
  auto path = path_of(80, 0.0);
  for (TrajectoryPoint& q : path) q.velocity = 4.0;
  EXPECT_DOUBLE_EQ(command_speed(path, 0, 1.0, p), 1.0 + p.delta_v_max);
  EXPECT_DOUBLE_EQ(command_speed(path, 0, 3.9, p), 4.0);
  for (TrajectoryPoint& q : path) q.velocity = 1.0;
  EXPECT_DOUBLE_EQ(command_speed(path, 0, 3.0, p), 3.0 + p.delta_v_min);
}

TEST(CommandSpeed, it_is_the_planned_speed_at_the_preview_point) {
  VelocityProfileParams p;
  p.preview_time = 0.25;
  p.delta_v_max = 10.0;
  p.delta_v_min = -10.0;
  auto path = path_of(80, 0.0);
  for (TrajectoryPoint& q : path) q.velocity = q.s;
  EXPECT_NEAR(command_speed(path, 10, 4.0, p), 1.0 + 4.0 * 0.25, 0.1 + 1e-9) << "to within one sample";
}

TEST(CommandSpeed, at_the_end_of_the_path_it_takes_the_last_point) {
  auto path = path_of(5, 0.0);
  for (TrajectoryPoint& q : path) q.velocity = 2.0;
  EXPECT_DOUBLE_EQ(command_speed(path, 4, 2.0, {}), 2.0);
}

}  // namespace
}  // namespace firstlap
