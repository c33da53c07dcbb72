#include "firstlap/control/stanley.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "firstlap/planning/trajectory.hpp"

namespace firstlap {
namespace {

constexpr CarGeometry car;

// A straight path past the front axle.
Buffer<TrajectoryPoint> line(double y, double yaw) {
  Buffer<TrajectoryPoint> path(max_path_points);
  for (int i = 0; i < 80; ++i)
    path.push({0.1 * i, car.wheelbase + 0.1 * i * std::cos(yaw), y + 0.1 * i * std::sin(yaw), yaw, 0.0, 3.0});
  return path;
}

// A circle through the front axle with heading `yaw` there; index 0 is at the axle.
Buffer<TrajectoryPoint> circle(double curvature, double yaw) {
  Buffer<TrajectoryPoint> path(max_path_points);
  for (int i = 0; i < 200; ++i) {
    const double s = 0.02 * i;
    const double heading = yaw + curvature * s;
    path.push({s, car.wheelbase + (std::sin(heading) - std::sin(yaw)) / curvature,
               -(std::cos(heading) - std::cos(yaw)) / curvature, heading, curvature, 3.0});
  }
  return path;
}

StanleyParams only(double StanleyParams::*gain, double value) {
  StanleyParams p;
  p.k_ang = p.k_dist = p.k_rate = p.k_steer = p.k_ag = 0.0;
  p.*gain = value;
  return p;
}

SteeringTerms terms(const Buffer<TrajectoryPoint>& path, const VehicleState& state, const StanleyParams& params,
                    double previous = 0.0) {
  TrajectoryPoint point;
  return track_path({path, 0, state, previous}, params, car, point);
}

TEST(Stanley, the_heading_term_alone_steers_in_the_direction_of_the_path) {
  const StanleyParams p = only(&StanleyParams::k_ang, 0.6);
  EXPECT_NEAR(terms(line(0.0, 0.3), {3.0, 0.0, 0.0}, p).steering_angle, 0.6 * 0.3, 1e-12);
  EXPECT_NEAR(terms(line(0.0, -0.3), {3.0, 0.0, 0.0}, p).steering_angle, -0.6 * 0.3, 1e-12);
}

TEST(Stanley, the_cross_track_term_alone_steers_toward_the_path) {
  const StanleyParams p = only(&StanleyParams::k_dist, 0.5);
  const double expected = std::atan(0.5 * 0.4 / (1.0 * 3.0 + 5.0));
  EXPECT_NEAR(terms(line(0.4, 0.0), {3.0, 0.0, 0.0}, p).steering_angle, expected, 1e-12) << "path left, steer left";
  EXPECT_NEAR(terms(line(-0.4, 0.0), {3.0, 0.0, 0.0}, p).steering_angle, -expected, 1e-12);
}

TEST(Stanley, the_cross_track_error_is_measured_from_the_front_axle) {
  const StanleyParams p = only(&StanleyParams::k_dist, 0.5);
  EXPECT_NEAR(terms(line(0.0, 0.5), {3.0, 0.0, 0.0}, p).cross_track_error, 0.0, 1e-12);
}

TEST(Stanley, the_yaw_rate_term_alone_has_the_sign_of_car_minus_path) {
  const StanleyParams p = only(&StanleyParams::k_rate, 0.01);
  EXPECT_NEAR(terms(line(0.0, 0.0), {3.0, 0.7, 0.0}, p).steering_angle, 0.01 * 0.7, 1e-12);
  EXPECT_NEAR(terms(circle(0.5, 0.0), {3.0, 0.0, 0.0}, p).steering_angle, -0.01 * 3.0 * 0.5, 1e-12);
  EXPECT_NEAR(terms(circle(0.5, 0.0), {3.0, 1.5, 0.0}, p).steering_angle, 0.0, 1e-12) << "turning with the path";
}

TEST(Stanley, the_yaw_rate_reference_is_selectable) {
  StanleyParams p = only(&StanleyParams::k_rate, 0.01);
  p.l_max = 1.0;
  auto path = line(0.0, 0.0);
  for (std::size_t i = 5; i < path.size(); ++i) path[i].curvature = 0.4;  // at the lookahead point only
  EXPECT_NEAR(terms(path, {2.0, 1.0, 0.0}, p).yaw_rate_error, 1.0 - 2.0 * 0.4, 1e-9);
  p.rate_reference = 1;
  EXPECT_NEAR(terms(path, {2.0, 1.0, 0.0}, p).yaw_rate_error, 1.0, 1e-9);
  p.rate_reference = 2;
  EXPECT_NEAR(terms(circle(0.4, 0.0), {2.0, 1.0, 0.0}, p).yaw_rate_error, 1.0, 1e-9);
}

TEST(Stanley, the_steering_term_alone_has_the_sign_of_the_steering_change) {
  const StanleyParams p = only(&StanleyParams::k_steer, 0.2);
  EXPECT_NEAR(terms(line(0.0, 0.0), {3.0, 0.0, 0.3}, p, 0.1).steering_angle, 0.2 * 0.2, 1e-12);
  EXPECT_NEAR(terms(line(0.0, 0.0), {3.0, 0.0, 0.1}, p, 0.3).steering_angle, -0.2 * 0.2, 1e-12);
}

TEST(Stanley, the_steady_state_yaw_adds_k_ag_v_squared_kappa_to_the_heading_error) {
  StanleyParams p = only(&StanleyParams::k_ang, 0.6);
  const auto path = circle(0.5, 0.1);
  const double without = terms(path, {4.0, 0.0, 0.0}, p).heading_error;
  p.k_ag = 0.013;
  EXPECT_NEAR(terms(path, {4.0, 0.0, 0.0}, p).heading_error - without, 0.013 * 16.0 * 0.5, 1e-12);
}

TEST(Stanley, the_command_is_the_sum_of_its_four_terms) {
  StanleyParams p;
  p.k_steer = 0.1;
  const SteeringTerms t = terms(circle(0.3, 0.2), {3.0, 0.5, 0.2}, p, 0.1);
  EXPECT_DOUBLE_EQ(t.steering_angle, t.heading + t.cross_track + t.yaw_rate + t.steering);
}

// In a steady circle without slip the steering angle is delta = wheelbase kappa and the front axle moves in the
// direction of the wheels: relative to the car, the path has that angle.
TEST(Stanley, with_the_neutral_lookahead_a_steady_circle_commands_the_ackermann_angle) {
  for (const double k_ang : {0.3, 0.45, 0.6}) {
    for (const double curvature : {-0.4, 0.1, 0.4}) {
      StanleyParams p = only(&StanleyParams::k_ang, k_ang);
      p.l_max = car.wheelbase * (1.0 / k_ang - 1.0);  // k_ang (1 + L / wheelbase) = 1
      p.kappa_n = 1e9;                                // the lookahead itself, not shortened by curvature
      const double ackermann = car.wheelbase * curvature;
      const auto path = circle(curvature, ackermann);
      EXPECT_NEAR(terms(path, {3.0, 3.0 * curvature, ackermann}, p).steering_angle, ackermann, 1e-3) << k_ang;
    }
  }
}

TEST(Stanley, more_lookahead_than_neutral_cuts_inside_and_less_runs_wide) {
  StanleyParams p = only(&StanleyParams::k_ang, 0.6);
  p.kappa_n = 1e9;
  const double ackermann = car.wheelbase * 0.4;
  p.l_max = 0.4;
  EXPECT_GT(terms(circle(0.4, ackermann), {3.0, 1.2, ackermann}, p).steering_angle, ackermann);
  p.l_max = 0.1;
  EXPECT_LT(terms(circle(0.4, ackermann), {3.0, 1.2, ackermann}, p).steering_angle, ackermann);
}

TEST(Stanley, the_lookahead_shrinks_with_curvature_and_halves_at_kappa_n) {
  StanleyParams p;
  p.l_max = 0.8;
  EXPECT_DOUBLE_EQ(terms(line(0.0, 0.0), {3.0, 0.0, 0.0}, p).lookahead, 0.8);
  p.kappa_n = 0.5;
  EXPECT_NEAR(terms(circle(0.5, 0.0), {3.0, 0.0, 0.0}, p).lookahead, 0.4, 1e-12);
  EXPECT_NEAR(terms(circle(-0.5, 0.0), {3.0, 0.0, 0.0}, p).lookahead, 0.4, 1e-12);
}

TEST(Stanley, the_schedule_keeps_the_crossover_and_a_neutral_lookahead_at_every_speed) {
  StanleyParams p;
  p.schedule_omega = 7.0;
  p.l_max = 5.0;
  for (double v = 0.5; v < 12.0; v += 0.5) {
    const SteeringTerms t = terms(line(0.0, 0.0), {v, 0.0, 0.0}, p);
    EXPECT_LE(v * t.k_ang / car.wheelbase, 7.0 + 1e-9) << "crossover";
    EXPECT_NEAR(t.k_ang * (1.0 + t.lookahead / car.wheelbase), 1.0, 1e-9) << "neutral";
    EXPECT_LE(t.k_ang, 0.6);
  }
}

TEST(Stanley, a_mirrored_path_mirrors_every_term) {
  auto path = circle(0.4, 0.2);
  auto mirror = path;
  for (TrajectoryPoint& q : mirror) q = {q.s, q.x, -q.y, -q.yaw, -q.curvature, q.velocity};
  StanleyParams p;
  p.k_steer = 0.1;
  const SteeringTerms a = terms(path, {3.0, 0.5, 0.2}, p, 0.1);
  const SteeringTerms b = terms(mirror, {3.0, -0.5, -0.2}, p, -0.1);
  EXPECT_EQ(a.heading, -b.heading);
  EXPECT_EQ(a.cross_track, -b.cross_track);
  EXPECT_EQ(a.yaw_rate, -b.yaw_rate);
  EXPECT_EQ(a.steering, -b.steering);
  EXPECT_EQ(a.lookahead, b.lookahead);
}

TEST(Stanley, a_heading_error_is_wrapped) {
  const StanleyParams p = only(&StanleyParams::k_ang, 1.0);
  EXPECT_NEAR(terms(line(0.0, 2.0 * 3.14159265358979 + 0.1), {1.0, 0.0, 0.0}, p).steering_angle, 0.1, 1e-9);
}

TEST(Stanley, a_lookahead_beyond_the_paths_end_takes_the_last_point) {
  StanleyParams p;
  p.l_max = 5.0;
  Buffer<TrajectoryPoint> path(8);
  for (int i = 0; i < 4; ++i) path.push({0.1 * i, car.wheelbase + 0.1 * i, 0.1, 0.0, 0.0, 1.0});
  TrajectoryPoint point;
  track_path({path, 0, {1.0, 0.0, 0.0}, 0.0}, p, car, point);
  EXPECT_DOUBLE_EQ(point.x, path.back().x);
}

TEST(Stanley, a_car_that_rolls_backward_gets_a_finite_command) {
  StanleyParams p;
  p.k_soft = 0.01;
  const SteeringTerms t = terms(line(0.5, 0.1), {-5.0, 0.0, 0.0}, p);
  EXPECT_TRUE(std::isfinite(t.steering_angle));
  EXPECT_GT(t.cross_track, 0.0);
}

}  // namespace
}  // namespace firstlap
