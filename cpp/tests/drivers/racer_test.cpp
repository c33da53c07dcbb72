#include "firstlap/drivers/racer.hpp"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/random_inputs.hpp"

namespace firstlap {
namespace {

using scene::Course;
using scene::Scan;

static_assert(noexcept(std::declval<Racer&>().step(std::declval<LaserScan>(), std::declval<VehicleState>(), 0.025)));
static_assert(noexcept(std::declval<Racer&>().reset()));
static_assert(noexcept(std::declval<const Racer&>().trace()));
static_assert(noexcept(std::declval<Driver&>().step(std::declval<LaserScan>(), std::declval<VehicleState>(), 0.025)));

// The same scene repeatedly, at standstill: the width is learned and the steering angle settles.
StepResult settle(Racer& racer, const Scan& scan, double speed = 0.0, double yaw_rate = 0.0, int steps = 1) {
  StepResult result;
  for (int i = 0; i < steps; ++i) result = racer.step(scan.view(), {speed, yaw_rate, 0.0}, 0.025);
  return result;
}

bool same_bits(const StepResult& a, const StepResult& b) {
  return std::memcmp(&a.command, &b.command, sizeof a.command) == 0 && a.status == b.status;
}

// Closed forms ----------------------------------------------------------------------------------------

TEST(RacerClosedForm, in_a_straight_corridor_the_width_is_exact_within_a_cm_and_the_line_in_the_middle) {
  for (const double width : {1.0, 1.4, 2.0, 2.7, 3.5}) {
    Racer racer{Params{}};
    const StepResult result = settle(racer, Course{}.straight(40).walls(width).scan({10, 0, 0}), 2.0);
    EXPECT_EQ(result.status, Status::ok) << width;
    EXPECT_NEAR(result.command.steering_angle, 0.0, 0.002) << width;
    ASSERT_GT(racer.trace().line.ahead, 4.0) << width;
    int pairs = 0;
    for (const CenterlinePoint& p : racer.trace().line.points) {
      EXPECT_NEAR(p.y, 0.0, 0.01) << width;
      if (p.support != WallSupport::both) continue;
      ++pairs;
      EXPECT_NEAR(p.width, width, 0.01) << width;
    }
    EXPECT_GT(pairs, 30) << width;
  }
}

TEST(RacerClosedForm, an_off_center_and_angled_car_finds_the_same_centerline_and_steers_back) {
  for (const Pose2 car : {Pose2{10, 0.4, 0}, Pose2{10, -0.4, 0}, Pose2{10, 0, 0.3}, Pose2{10, 0, -0.3},
                          Pose2{10, 0.3, 0.25}, Pose2{10, -0.3, -0.25}}) {
    Racer racer{Params{}};
    const StepResult result = settle(racer, Course{}.straight(40).walls(2.0).scan(car), 2.0, 0.0, 8);
    EXPECT_EQ(result.status, Status::ok);
    const Trace& trace = racer.trace();
    for (std::size_t i = trace.line.nearest; i < trace.line.points.size(); ++i)
      EXPECT_NEAR(scene::to_world(car, trace.line.points[i].x, trace.line.points[i].y).y, 0.0, 0.02);
    EXPECT_LT(result.command.steering_angle * (car.y + car.yaw), 0.0) << "at y " << car.y << ", yaw " << car.yaw;
  }
}

TEST(RacerClosedForm, on_a_circle_the_curvature_is_one_over_the_radius_and_the_speed_the_root_of_a_y_r) {
  for (const double radius : {1.5, 2.5, 5.0}) {
    for (const double sign : {-1.0, 1.0}) {
      Params params;
      params.trajectory.join_distance = 0.0;
      params.track_width.width_initial = 1.4;
      params.track_width.apex_width = 0.0;  // where the inner wall is occluded, the width stays the same
      params.velocity_profile.v_min = 0.5;
      params.velocity_profile.v_max = 10.0;
      Racer racer{params};
      const Course course = Course{}.turn(radius, sign * 1.9 * scene::pi);
      const double v = std::sqrt(params.velocity_profile.a_y_max * radius);
      const Pose2 car = course.at(0.6 * course.length());
      const StepResult result = settle(racer, course.walls(1.4).scan(car), v, sign * v / radius, 4);
      ASSERT_EQ(result.status, Status::ok) << radius;
      const Trace& trace = racer.trace();
      double kappa = 0.0;
      int count = 0;
      for (std::size_t i = trace.nearest; i < trace.path.size() && trace.path[i].s < trace.path[trace.nearest].s + 1.5;
           ++i, ++count) {
        kappa += trace.path[i].curvature;
        EXPECT_NEAR(trace.path[i].velocity, v, 0.1 * v) << radius;
      }
      EXPECT_NEAR(kappa / count * sign * radius, 1.0, 0.05) << radius;
      EXPECT_NEAR(result.command.speed, v, 0.08 * v) << radius;
      EXPECT_LT(scene::line_error(trace, course, car, 2.0), 0.03) << radius;
    }
  }
}

TEST(RacerClosedForm, the_width_follows_a_step_from_1_m_to_2_m_within_one_scan) {
  scene::Scene scene;
  for (const int side : {scene::right, scene::left})
    scene.add(side, {{-5, 0.5 * side}, {2, 0.5 * side}, {2, 1.0 * side}, {25, 1.0 * side}});
  Racer racer{Params{}};
  ASSERT_EQ(settle(racer, scene.scan({0, 0, 0}), 2.0).status, Status::ok);
  double last_narrow = 0.0;
  int wide = 0;
  for (const CenterlinePoint& p : racer.trace().line.points) {
    EXPECT_NEAR(p.y, 0.0, 0.02) << p.x;
    if (p.x < 1.8) {
      EXPECT_NEAR(p.width, 1.0, 0.01) << p.x;
      last_narrow = p.x;
    }
    if (p.x > 2.5 && p.support == WallSupport::both) {
      EXPECT_NEAR(p.width, 2.0, 0.03) << p.x << ": from the first pair on";
      ++wide;
    }
  }
  EXPECT_GT(last_narrow, 1.5);
  EXPECT_GT(wide, 20);
  EXPECT_GT(racer.trace().line.points.back().x, 6.0);
}

// The paper's figure: the track widens from 1 m to 2 m within one scan. Of the wide part only a few pairs of walls are
// visible; beyond them, the mean of the last pairs alone decides how far the line is from the right wall.
TEST(RacerClosedForm, where_a_wall_is_hidden_beyond_a_step_the_moving_average_decides_where_the_line_is) {
  scene::Scene scene;
  scene.add(scene::right, {{-5, -0.5}, {25, -0.5}});
  scene.add(scene::left, {{-5, 0.5}, {2, 0.5}, {2, 1.5}, {6.0, 1.5}});
  for (const int window : {1, 7, 10}) {
    Params params;
    params.track_width.width_window = window;
    params.track_width.width_blend = 20.0;  // hardly any memory
    params.track_width.apex_width = 0.0;
    params.centerline.sight_length = 0.0;
    Racer racer{params};
    ASSERT_EQ(settle(racer, scene.scan({0, 0, 0}), 2.0).status, Status::ok);
    int wide = 0, beyond = 0;
    for (const CenterlinePoint& p : racer.trace().line.points) {
      wide += p.x > 2.0 && p.support == WallSupport::both;
      if (p.x < 7.0 || p.x > 8.0) continue;
      ++beyond;
      const double expected = 1.0 + std::min(1.0, static_cast<double>(wide) / window);
      EXPECT_NEAR(p.width, expected, 0.1) << "window " << window << ", x " << p.x;
      EXPECT_NEAR(p.y, -0.5 + 0.5 * p.width, 0.02) << "window " << window << ", x " << p.x;
    }
    EXPECT_GT(wide, 2);
    EXPECT_LT(wide, 7);
    EXPECT_GT(beyond, 5);
  }
}

TEST(RacerClosedForm, a_step_on_one_side_moves_the_line_by_half_of_it) {
  scene::Scene scene;
  scene.add(scene::right, {{-5, -0.5}, {25, -0.5}});
  scene.add(scene::left, {{-5, 0.5}, {2, 0.5}, {2, 1.5}, {25, 1.5}});
  Racer racer{Params{}};
  ASSERT_EQ(settle(racer, scene.scan({0, 0, 0}), 2.0).status, Status::ok);
  EXPECT_GT(racer.trace().line.points.back().x, 6.0);
  for (const CenterlinePoint& p : racer.trace().line.points) {
    if (p.x < 1.2) {
      EXPECT_NEAR(p.y, 0.0, 0.02) << p.x;
    }
    if (p.x > 5.5) {
      EXPECT_NEAR(p.y, 0.5, 0.05) << p.x;
      if (p.support == WallSupport::both) {
        EXPECT_NEAR(p.width, 2.0, 0.03) << p.x;
      }
    }
  }
}

// A corridor wider than the pair limit: the line must not follow one wall closely.
TEST(RacerClosedForm, in_a_corridor_wider_than_the_pair_limit_the_line_stays_off_both_walls) {
  for (const double width : {4.5, 6.0}) {
    Racer racer{Params{}};
    const Scan scan = Course{}.straight(40).walls(width).scan({10, 0, 0});
    EXPECT_EQ(settle(racer, scan, 2.0, 0.0, 4).status, Status::ok) << width;
    for (std::size_t i = racer.trace().line.nearest; i < racer.trace().line.points.size(); ++i)
      EXPECT_LT(std::abs(racer.trace().line.points[i].y), 0.5 * width - 0.7) << width;
  }
}

TEST(RacerClosedForm, the_first_scan_sets_the_width_and_later_ones_change_it_by_a_share) {
  Racer racer{Params{}};
  settle(racer, Course{}.straight(40).walls(1.4).scan({10, 0, 0}), 1.0);
  EXPECT_NEAR(racer.trace().width, 1.4, 0.005);
  settle(racer, Course{}.straight(40).walls(2.0).scan({10, 0, 0}), 1.0);
  EXPECT_NEAR(racer.trace().width, 1.4 + TrackWidthParams{}.width_gain * (2.0 - 1.4), 0.005);
}

TEST(RacerClosedForm, pairs_narrower_than_width_min_do_not_change_the_width) {
  const TrackWidthParams p;
  for (const double width : {p.width_min - 0.1, p.width_min + 0.1}) {
    Racer racer{Params{}};
    ASSERT_EQ(settle(racer, Course{}.straight(40).walls(width).scan({10, 0, 0}), 1.0, 0.0, 5).status, Status::ok);
    EXPECT_NEAR(racer.trace().width, width < p.width_min ? p.width_initial : width, 0.01) << width;
  }
}

TEST(RacerClosedForm, a_track_wider_than_width_max_is_learned_as_width_max) {
  const TrackWidthParams p;
  Racer racer{Params{}};
  const Scan scan = Course{}.straight(40).walls(p.width_max + 2.0).scan({10, 0.5, 0});
  ASSERT_EQ(settle(racer, scan, 2.0, 0.0, 4).status, Status::ok);
  EXPECT_NEAR(racer.trace().width, p.width_max, 1e-9);
  const double middle = 0.5 * (p.width_max + 2.0) - 0.5 - 0.5 * p.width_max;  // from the nearer, left wall
  for (const CenterlinePoint& c : racer.trace().line.points) EXPECT_NEAR(c.y, middle, 0.02) << c.x;
}

// Between the stages -----------------------------------------------------------------------------------

// Distance of (x, y) to the planned path.
double path_distance(const Trace& trace, double x, double y) {
  double best = 1e9;
  for (const TrajectoryPoint& p : trace.path) best = std::min(best, std::hypot(p.x - x, p.y - y));
  return best;
}

TEST(RacerStages, the_path_starts_at_the_car_and_joins_the_centerline) {
  const Scan scan = Course{}.straight(40).walls(2.0).scan({10, 0.4, 0.0});
  for (const double speed : {1.0, 4.0}) {
    Params params;
    Racer racer{params};
    ASSERT_EQ(settle(racer, scan, speed, 0.0, 3).status, Status::ok);
    const Trace& trace = racer.trace();
    EXPECT_LT(path_distance(trace, 0.0, 0.0), 0.06) << speed;
    // Over the join distance, or the join time at speed; one meter before its end the path has not joined yet.
    const double joined = std::max(params.trajectory.join_distance, params.trajectory.join_time * speed);
    EXPECT_LT(path_distance(trace, joined + 0.5, -0.4), 0.06) << speed;
    EXPECT_GT(path_distance(trace, joined - 0.9, -0.4), 0.06) << speed;
    params.trajectory.join_distance = 0.0;
    Racer without{params};
    settle(without, scan, speed, 0.0, 3);
    EXPECT_GT(path_distance(without.trace(), 0.0, 0.0), 0.35) << "no distance: the centerline itself";
  }
}

TEST(RacerStages, from_the_previous_path_the_path_comes_to_the_centerline_while_the_car_stays_beside_it) {
  const Scan scan = Course{}.straight(40).walls(2.0).scan({10, 0.4, 0.0});
  Params params;
  params.trajectory.join_previous = true;
  params.trajectory.join_time = 0.0;
  Racer racer{params};
  settle(racer, scan, 2.0, 0.0, 1);
  EXPECT_LT(path_distance(racer.trace(), 0.0, 0.0), 0.06) << "there is no previous path yet";
  settle(racer, scan, 2.0, 0.0, 100);  // 5 m, of which the join needs 1 m
  EXPECT_LT(path_distance(racer.trace(), 0.0, -0.4), 0.06);
  EXPECT_NEAR(racer.trace().steering.cross_track_error, -0.4, 0.02) << "all of it is left to the steering law";
}

TEST(RacerStages, the_path_is_the_spline_through_the_points_of_the_smoothed_line_that_opheim_keeps) {
  const Course course = Course{}.straight(4).turn(2.0, 1.5).straight(8);
  const Params params;
  Racer racer{params};
  ASSERT_EQ(settle(racer, course.walls(1.8).scan(course.at(2.5)), 2.0).status, Status::ok);
  const Trace& trace = racer.trace();
  Buffer<Point2> knots(max_line_points);
  simplify_opheim(trace.smoothed, params.trajectory.opheim_min, params.trajectory.opheim_max, knots);
  ASSERT_LT(2 * knots.size(), trace.smoothed.size()) << "most points of the line are redundant";
  ASSERT_EQ(trace.simplified.size(), knots.size());
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(knots, params.trajectory.sample, params.trajectory.end_hold, spline, path);
  ASSERT_EQ(trace.path.size(), path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(trace.path[i].x, path[i].x);
    EXPECT_EQ(trace.path[i].y, path[i].y);
    EXPECT_EQ(trace.path[i].curvature, path[i].curvature);
  }
}

TEST(RacerStages, the_steering_change_is_measured_from_the_previous_scan) {
  const Scan scan = Course{}.straight(40).walls(2.0).scan({10, 0, 0});
  Params params;
  params.stanley.k_steer = 0.2;
  Racer racer{params};
  const double angles[] = {0.0, 0.05, 0.15, 0.15};
  double before = 0.0;
  for (const double angle : angles) {
    ASSERT_EQ(racer.step(scan.view(), {2.0, 0.0, angle}, 0.025).status, Status::ok);
    EXPECT_NEAR(racer.trace().steering.steering_change, angle - before, 1e-12);
    EXPECT_NEAR(racer.trace().steering.steering, 0.2 * (angle - before), 1e-12);
    before = angle;
  }
}

// Laws ------------------------------------------------------------------------------------------------

std::vector<std::pair<const char*, Course>> courses() {
  return {{"straight", Course{}.straight(20)},
          {"left-hand curve", Course{}.straight(3).turn(2.0, 1.5).straight(6)},
          {"right-hand curve", Course{}.straight(3).turn(2.0, -1.5).straight(6)},
          {"slalom", Course{}.straight(3).turn(1.5, 1.0).turn(1.5, -2.0).turn(1.5, 1.0).straight(4)},
          {"hairpin", Course{}.straight(4).turn(1.2, scene::pi).straight(6)}};
}

TEST(RacerLaw, a_mirrored_scan_mirrors_the_steering_and_keeps_the_speed) {
  const auto seed = scene::seed_or(1);
  scene::RandomInputs random(seed);
  for (const auto& [name, course] : courses()) {
    for (int run = 0; run < 40; ++run) {
      Pose2 car = course.at(random.uniform(1.0, 0.6 * course.length()), random.uniform(-0.4, 0.4));
      car.yaw += random.uniform(-0.3, 0.3);
      const Scan scan = course.walls(1.8).scan(car);
      const double speed = random.uniform(0.0, 4.0);
      const double yaw_rate = random.uniform(-1.0, 1.0);
      Racer a{Params{}};
      Racer b{Params{}};
      settle(a, scan, 0.0, 0.0, 5);
      settle(b, scan.mirrored(), 0.0, 0.0, 5);
      const StepResult as = settle(a, scan, speed, yaw_rate);
      const StepResult bs = settle(b, scan.mirrored(), speed, -yaw_rate);
      EXPECT_EQ(as.status, bs.status) << name << " run " << run;
      EXPECT_NEAR(as.command.steering_angle, -bs.command.steering_angle, 0.01) << name << " run " << run;
      EXPECT_NEAR(as.command.speed, bs.command.speed, 0.05) << name << " run " << run;
    }
  }
}

TEST(RacerLaw, clockwise_beams_give_the_same_command) {
  for (const auto& [name, course] : courses()) {
    const Scan scan = course.walls(1.8).scan(course.at(2.0, 0.2));
    Scan clockwise = scan.mirrored();
    clockwise.angle_min = -clockwise.angle_min;
    clockwise.angle_increment = -clockwise.angle_increment;
    clockwise.angle_min = scan.angle_min + scan.angle_increment * 1080.0;
    Racer a{Params{}};
    Racer b{Params{}};
    const StepResult as = settle(a, scan, 2.0, 0.0, 4);
    const StepResult bs = settle(b, clockwise, 2.0, 0.0, 4);
    EXPECT_NEAR(as.command.steering_angle, bs.command.steering_angle, 1e-6) << name;
    EXPECT_NEAR(as.command.speed, bs.command.speed, 1e-6) << name;
  }
}

TEST(RacerLaw, a_higher_v_max_never_lowers_a_velocity) {
  for (const auto& [name, course] : courses()) {
    const Scan scan = course.walls(1.8).scan(course.at(2.0, 0.1));
    std::vector<double> before;
    for (const double v_max : {3.0, 4.0, 6.0, 10.0}) {
      Params params;
      params.velocity_profile.v_max = v_max;
      Racer racer{params};
      settle(racer, scan, 2.5);
      const auto& path = racer.trace().path;
      for (std::size_t i = 0; i < before.size() && i < path.size(); ++i)
        EXPECT_GE(path[i].velocity, before[i]) << name << ' ' << v_max;
      before.clear();
      for (const TrajectoryPoint& p : path) before.push_back(p.velocity);
    }
  }
}

TEST(RacerLaw, the_steering_angle_changes_at_most_at_its_rate_and_never_beyond_its_limit) {
  const auto seed = scene::seed_or(3);
  scene::RandomInputs random(seed);
  const Course course = Course{}.straight(3).turn(1.2, 3.0).turn(1.2, -3.0).straight(5);
  const scene::Scene scene = course.walls(1.8);
  Params params;
  params.stanley.k_ang = 2.0;
  params.stanley.k_dist = 10.0;
  Racer racer{params};
  double before = 0.0;
  for (int i = 0; i < 300; ++i) {
    Pose2 car = course.at(random.uniform(1.0, course.length() - 2.0), random.uniform(-0.5, 0.5));
    car.yaw += random.uniform(-0.8, 0.8);
    const double dt = random.uniform(0.01, 0.05);
    const double angle = racer.step(scene.scan(car).view(), {2.0, 0.0, 0.0}, dt).command.steering_angle;
    EXPECT_LE(std::abs(angle), params.car.steering_limit);
    EXPECT_LE(std::abs(angle - before), params.car.steering_rate * dt + 1e-12);
    before = angle;
  }
}

TEST(RacerLaw, the_commanded_speed_is_never_above_v_max) {
  const Params params;
  Racer racer{params};
  const Scan scan = Course{}.straight(40).walls(2.0).scan({10, 0, 0});
  EXPECT_EQ(settle(racer, scan, params.velocity_profile.v_max + 2.0).command.speed, params.velocity_profile.v_max);
}

TEST(RacerLaw, the_commanded_speed_changes_by_at_most_the_two_deltas) {
  const Course course = Course{}.straight(4).turn(1.2, scene::pi).straight(6);
  const scene::Scene scene = course.walls(1.8);
  const VelocityProfileParams p = Params{}.velocity_profile;
  for (double s = 1.0; s < 9.0; s += 0.5) {
    for (double speed = 0.0; speed < 4.5; speed += 0.5) {
      Racer racer{Params{}};
      const StepResult r = racer.step(scene.scan(course.at(s)).view(), {speed, 0.0, 0.0}, 0.025);
      if (r.status != Status::ok) continue;
      EXPECT_LE(r.command.speed, speed + p.delta_v_max + 1e-12);
      EXPECT_GE(r.command.speed, std::min(speed + p.delta_v_min, p.v_max) - 1e-12);
    }
  }
}

// Memory ----------------------------------------------------------------------------------------------

// A car drives at 6 m/s, whatever the commands, toward a wall across a corridor; from step `blind` on every scan is
// empty. Returns the step at which the racer first brakes as hard as it can.
int braked_at(int blind) {
  constexpr double speed = 6.0;
  constexpr double dt = 0.025;
  scene::Scene scene = Course{}.straight(40).walls(2.4);
  scene.box(scene::neither, 24.0, -0.9, 0.3, 1.8);
  Params params;
  params.velocity_profile.v_max = 7.0;
  params.velocity_profile.a_x_min = -2.6;
  Racer racer{params};
  for (int i = 0; i < 200; ++i) {
    Scan scan = scene.scan({6.0 + speed * dt * i, 0.0, 0.0});
    if (i >= blind) scan.ranges.assign(scan.ranges.size(), 0.0F);
    const StepResult result = racer.step(scan.view(), {speed, 0.0, 0.0}, dt);
    if (result.command.speed == 0.0) return i;
  }
  return -1;
}

TEST(RacerMemory, a_car_that_holds_on_invalid_scans_brakes_where_it_would_on_valid_ones) {
  const int seeing = braked_at(1000);
  ASSERT_GT(seeing, 20);
  for (int blind = 1; blind < 7; ++blind) {
    const int holding = braked_at(seeing - blind);
    EXPECT_LE(holding, seeing + 1) << blind << " scans blind";
    EXPECT_GE(holding, seeing - 2) << blind << " scans blind";
  }
}

TEST(RacerMemory, an_occluded_wall_is_remembered_for_memory_time) {
  const Params params;
  Racer racer{params};
  Scan scan = Course{}.straight(30).walls(2.0).scan({10, 0, 0});
  settle(racer, scan, 0.0, 0.0, 2);
  for (std::size_t i = 700; i < 860; ++i) scan.ranges[i] = 0.0F;  // 40 to 80 degrees to the left
  const auto remembered = [&] {
    const WallSide& left = racer.trace().walls.left;
    std::size_t count = 0;
    for (std::size_t i = 0; i < left.size(); ++i) count += left.age[i] > 0.0F && left.x[i] > 0.6F && left.x[i] < 1.3F;
    return count;
  };
  settle(racer, scan);
  EXPECT_GT(remembered(), 1U);
  settle(racer, scan, 0.0, 0.0, static_cast<int>(params.centerline.memory_time / 0.025) + 2);
  EXPECT_EQ(remembered(), 0U);
}

TEST(RacerMemory, the_walls_that_a_held_path_is_checked_against_move_with_it) {
  Racer racer{Params{}};
  Scan scan = Course{}.straight(30).walls(2.0).scan({10, 0, 0});
  settle(racer, scan, 2.0, 0.0, 3);
  const double clearance = racer.trace().clearance;
  ASSERT_GT(clearance, 0.7);
  scan.ranges.assign(scan.ranges.size(), 0.0F);
  ASSERT_EQ(racer.step(scan.view(), {2.0, 2.0, 0.0}, 0.1).status, Status::holding);  // the car turns by 0.1 rad
  EXPECT_NEAR(racer.trace().clearance, clearance, 0.02);
}

TEST(RacerMemory, a_wall_is_forgotten_if_the_scan_sees_past_it) {
  Racer racer{Params{}};
  settle(racer, Course{}.straight(30).walls(2.0).scan({10, 0, 0}), 1.0, 0.0, 3);
  scene::Scene opened;
  opened.add(scene::right, {{0, -1}, {30, -1}});
  opened.add(scene::left, {{0, 1}, {12, 1}}).add(scene::left, {{15, 1}, {30, 1}});
  opened.add(scene::neither, {{5, 2.5}, {25, 2.5}});
  ASSERT_EQ(settle(racer, opened.scan({10, 0, 0}), 1.0).status, Status::ok);
  const WallSide& left = racer.trace().walls.left;
  for (std::size_t i = 0; i < left.size(); ++i)
    EXPECT_FALSE(left.y[i] < 1.5F && left.x[i] > 2.5F && left.x[i] < 4.5F) << left.x[i] << ' ' << left.age[i];
}

TEST(RacerMemory, the_memory_keeps_moving_while_the_state_is_implausible) {
  const Course course = Course{}.straight(4).turn(1.5, 1.5).straight(8);
  const scene::Scene scene = course.walls(1.8);
  Racer racer{Params{}};
  double s = 1.0;
  for (; s < 3.0; s += 0.1) racer.step(scene.scan(course.at(s)).view(), {4.0, 0.0, 0.0}, 0.025);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 4; ++i) racer.step(scene.scan(course.at(s)).view(), {nan, 0.0, 0.0}, 0.025);
  // Holding the path of 0.1 s ago: the wall is 0.4 m closer, plus 0.1 m of the step itself.
  const double before = racer.trace().line.points.empty() ? 0.0 : 1.0;
  EXPECT_EQ(before, 0.0);
  Scan nothing = scene.scan(course.at(s));
  nothing.ranges.assign(nothing.ranges.size(), 0.0F);
  EXPECT_EQ(racer.step(nothing.view(), {4.0, 0.0, 0.0}, 0.025).status, Status::holding);
  Racer seeing{Params{}};
  for (double t = 1.0; t < 3.0; t += 0.1) seeing.step(scene.scan(course.at(t)).view(), {4.0, 0.0, 0.0}, 0.025);
  seeing.step(nothing.view(), {4.0, 0.0, 0.0}, 0.025);
  EXPECT_NEAR(racer.trace().path[0].x, seeing.trace().path[0].x - 0.4, 0.02);
}

// Determinism -----------------------------------------------------------------------------------------

TEST(RacerDeterminism, the_same_inputs_give_the_same_bits) {
  const auto seed = scene::seed_or(5);
  scene::RandomInputs first(seed);
  scene::RandomInputs second(seed);
  Racer a{Params{}};
  Racer b{Params{}};
  for (int i = 0; i < scene::count_or(2000); ++i) {
    const Scan as = first.scan();
    const Scan bs = second.scan();
    const VehicleState state = first.state();
    const double dt = first.dt();
    second.state();
    second.dt();
    ASSERT_TRUE(same_bits(a.step(as.view(), state, dt), b.step(bs.view(), state, dt))) << scene::how_to_repeat(seed, i);
  }
}

TEST(RacerDeterminism, after_reset_it_behaves_like_a_new_racer) {
  const auto seed = scene::seed_or(6);
  scene::RandomInputs random(seed);
  for (int run = 0; run < scene::count_or(50); ++run) {
    Racer used{Params{}};
    for (int i = 0; i < 20; ++i) used.step(random.scan().view(), random.state(), random.dt());
    used.reset();
    Racer fresh{Params{}};
    for (int i = 0; i < 10; ++i) {
      const Scan scan = random.scan();
      const VehicleState state = random.state();
      const double dt = random.dt();
      ASSERT_TRUE(same_bits(used.step(scan.view(), state, dt), fresh.step(scan.view(), state, dt)))
          << scene::how_to_repeat(seed, run);
    }
  }
}

// Any input --------------------------------------------------------------------------------------------

// Split into parts that run in parallel, each with its own seeds.
class RacerRobustTo : public ::testing::TestWithParam<int> {};

TEST_P(RacerRobustTo, random_scans_and_states_give_finite_limited_commands) {
  const auto seed = scene::seed_or(static_cast<std::uint64_t>(GetParam()));
  scene::RandomInputs random(seed);
  Params params;
  params.velocity_profile.v_max = 10.0;
  Racer racer{params};
  for (int i = 0; i < scene::count_or(25000); ++i) {
    const Scan scan = random.scan();
    const StepResult r = racer.step(scan.view(), random.state(), random.dt());
    ASSERT_TRUE(std::isfinite(r.command.speed)) << scene::how_to_repeat(seed, i);
    ASSERT_TRUE(std::isfinite(r.command.steering_angle)) << scene::how_to_repeat(seed, i);
    ASSERT_GE(r.command.speed, 0.0) << scene::how_to_repeat(seed, i);
    ASSERT_LE(r.command.speed, params.velocity_profile.v_max) << scene::how_to_repeat(seed, i);
    ASSERT_LE(std::abs(r.command.steering_angle), params.car.steering_limit) << scene::how_to_repeat(seed, i);
    if (r.status != Status::ok && r.status != Status::holding && r.status != Status::blocked) {
      ASSERT_EQ(r.command.speed, 0.0) << scene::how_to_repeat(seed, i);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Part, RacerRobustTo, ::testing::Values(7, 107, 207, 307));

struct Absurd {
  const char* name;
  Scan scan;
  Status status;
};

std::vector<Absurd> absurd_scans() {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float inf = std::numeric_limits<float>::infinity();
  const Scan good = Course{}.straight(20).walls(2.0).scan({5, 0, 0});
  const auto with = [&](auto&& change) {
    Scan scan = good;
    change(scan);
    return scan;
  };
  const auto filled = [&](std::size_t n, float r) {
    return with([&](Scan& s) {
      s.ranges.assign(n, r);
      s.angle_increment = 1.5 * scene::pi / std::max(1.0, static_cast<double>(n) - 1.0);
    });
  };
  return {{"empty", filled(0, 0.0F), Status::bad_scan},
          {"one beam", filled(1, 1.0F), Status::bad_scan},
          {"all NaN", filled(1081, nan), Status::bad_scan},
          {"all infinite", filled(1081, inf), Status::bad_scan},
          {"all negative", filled(1081, -1.0F), Status::bad_scan},
          {"all zero", filled(1081, 0.0F), Status::bad_scan},
          {"zero increment", with([](Scan& s) { s.angle_increment = 0.0; }), Status::bad_scan},
          {"increment not a number", with([](Scan& s) { s.angle_increment = std::nan(""); }), Status::bad_scan},
          {"first angle infinite", with([](Scan& s) { s.angle_min = HUGE_VAL; }), Status::bad_scan},
          {"many turns", with([](Scan& s) { s.angle_increment = 1.0; }), Status::bad_scan},
          {"range limits swapped", with([](Scan& s) { std::swap(s.range_min, s.range_max); }), Status::bad_scan}};
}

TEST(RacerRobust, an_invalid_scan_is_a_bad_scan_and_a_stop) {
  for (const Absurd& absurd : absurd_scans()) {
    Racer racer{Params{}};
    const StepResult r = settle(racer, absurd.scan, 2.0);
    EXPECT_EQ(r.status, absurd.status) << absurd.name << ": " << to_string(r.status);
    EXPECT_EQ(r.command.speed, 0.0) << absurd.name;
  }
}

TEST(RacerRobust, a_wall_all_around_is_no_path) {
  Racer racer{Params{}};
  Scan scan;
  scan.ranges.assign(1081, 0.5F);
  EXPECT_EQ(settle(racer, scan, 1.0).command.speed, 0.0);
}

TEST(RacerRobust, ten_thousand_beams_give_the_command_of_one_thousand) {
  const scene::Scene scene = Course{}.straight(20).walls(2.0);
  const Scan few = scene.scan({5, 0.3, 0});
  Scan many = few;
  many.angle_increment = 1.5 * scene::pi / 9999.0;
  many.ranges.clear();
  for (int i = 0; i < 10000; ++i) {
    const double a = many.angle_min + i * many.angle_increment;
    const double y = std::sin(a) > 0.0 ? 0.7 : 1.3;  // distance of the walls beside the LiDAR
    double r = y / std::max(std::abs(std::sin(a)), 1e-6);
    r = std::cos(a) > 0.0 && r * std::cos(a) > 14.73 ? 1e9 : r;
    many.ranges.push_back(static_cast<float>(r));
  }
  Racer a{Params{}};
  Racer b{Params{}};
  const StepResult as = settle(a, few, 2.0, 0.0, 6);
  const StepResult bs = settle(b, many, 2.0, 0.0, 6);
  EXPECT_EQ(bs.status, Status::ok);
  EXPECT_NEAR(as.command.steering_angle, bs.command.steering_angle, 0.01);
}

TEST(RacerRobust, duplicated_beams_are_handled) {
  const Scan few = Course{}.straight(20).walls(2.0).scan({5, 0.3, 0});
  Scan twice = few;
  twice.angle_increment = 0.5 * few.angle_increment;
  twice.ranges.clear();
  for (const float r : few.ranges) twice.ranges.insert(twice.ranges.end(), {r, r});
  Racer racer{Params{}};
  const StepResult r = settle(racer, twice, 2.0, 0.0, 6);
  EXPECT_EQ(r.status, Status::ok);
  EXPECT_LT(scene::line_error(racer.trace(), Course{}.straight(20), {5, 0.3, 0}, 3.0), 0.03);
}

TEST(RacerRobust, an_implausible_state_is_a_bad_state_and_a_stop) {
  const Scan scan = Course{}.straight(20).walls(2.0).scan({5, 0, 0});
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e300, -1e300}) {
    for (const VehicleState state : {VehicleState{wrong, 0, 0}, VehicleState{0, wrong, 0}, VehicleState{0, 0, wrong}}) {
      Racer racer{Params{}};
      settle(racer, scan, 2.0, 0.0, 4);
      const StepResult r = racer.step(scan.view(), state, 0.025);
      EXPECT_EQ(r.status, Status::bad_state);
      EXPECT_EQ(r.command.speed, 0.0);
      EXPECT_EQ(settle(racer, scan, 2.0).status, Status::ok) << "the next plausible state resumes driving";
    }
    Racer racer{Params{}};
    const StepResult r = racer.step(scan.view(), {2.0, 0.0, 0.0}, wrong);
    EXPECT_TRUE(std::isfinite(r.command.steering_angle));
  }
}

// Safety ----------------------------------------------------------------------------------------------

struct Outage {
  std::vector<Status> statuses;
  std::vector<double> speeds;
  std::vector<double> angles;
};

// Two seconds in a corridor, then 40 empty scans.
Outage outage(const Scan& nothing) {
  const Course course = Course{}.straight(40);
  const scene::Scene scene = course.walls(2.0);
  Racer racer{Params{}};
  scene::carry(racer, scene, course, 5.0, 7.0);
  Outage out;
  for (int i = 0; i < 40; ++i) {
    const StepResult r = racer.step(nothing.view(), {2.0, 0.0, 0.0}, 0.025);
    out.statuses.push_back(r.status);
    out.speeds.push_back(r.command.speed);
    out.angles.push_back(r.command.steering_angle);
  }
  return out;
}

TEST(RacerSafety, without_scans_the_last_path_is_held_for_at_most_0_2_s_and_then_the_car_stops) {
  Scan empty;
  Scan blind;
  blind.ranges.assign(1081, 0.0F);
  for (const Scan& nothing : {empty, blind}) {
    const Outage out = outage(nothing);
    for (std::size_t i = 0; i < out.statuses.size(); ++i) {
      const double since = 0.025 * static_cast<double>(i + 1);
      if (since < 0.19) {
        EXPECT_EQ(out.statuses[i], Status::holding) << since;
        EXPECT_GT(out.speeds[i], 0.0) << since;
      }
      if (since > 0.21) {
        EXPECT_EQ(out.statuses[i], Status::bad_scan) << since;
        EXPECT_EQ(out.speeds[i], 0.0) << since;
      }
      EXPECT_NEAR(out.angles[i], 0.0, 0.02);
    }
  }
}

TEST(RacerSafety, the_path_ahead_shrinks_while_it_is_held) {
  const Course course = Course{}.straight(40);
  Racer racer{Params{}};
  scene::carry(racer, course.walls(2.0), course, 5.0, 7.0);
  const double before = racer.trace().path.back().x;
  racer.step(Scan{}.view(), {4.0, 0.0, 0.0}, 0.1);
  EXPECT_EQ(racer.trace().result.status, Status::holding);
  EXPECT_NEAR(racer.trace().path.back().x, before - 0.3, 0.02) << "mean of 2 and 4 m/s for 0.1 s";
}

TEST(RacerSafety, a_scan_after_an_outage_resumes_immediately) {
  const Course course = Course{}.straight(40);
  const scene::Scene scene = course.walls(2.0);
  Racer racer{Params{}};
  scene::carry(racer, scene, course, 5.0, 7.0);
  for (int i = 0; i < 40; ++i) racer.step(Scan{}.view(), {0.0, 0.0, 0.0}, 0.025);
  EXPECT_EQ(settle(racer, scene.scan({7, 0, 0})).status, Status::ok);
}

TEST(RacerSafety, a_first_scan_without_walls_never_moves_the_car) {
  Racer racer{Params{}};
  Scan scan;
  scan.ranges.assign(1081, 25.0F);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(settle(racer, scan).command.speed, 0.0);
}

TEST(RacerSafety, toward_a_wall_across_the_track_the_plan_ends_in_a_stop) {
  scene::Scene scene = Course{}.straight(10).walls(2.0);
  scene.add(scene::neither, {{10, -1}, {10, 1}});
  const Course course = Course{}.straight(12);
  Racer racer{Params{}};
  double x = 2.0;
  double speed = 3.0;
  for (int i = 0; i < 400 && x < 10.0; ++i) {
    const StepResult r = racer.step(scene.scan({x, 0, 0}).view(), {speed, 0.0, 0.0}, 0.025);
    speed += std::clamp(r.command.speed - speed, -0.12, 0.12);
    x += speed * 0.025;
  }
  EXPECT_LT(x, 10.0 - 0.455) << "the front bumper";
}

// Near the left wall of a corridor, steered toward it: the path leads back to the middle, but the car does not.
TEST(RacerSafety, a_car_whose_motion_leads_to_a_wall_brakes_although_its_path_is_clear) {
  const Scan scan = Course{}.straight(40).walls(1.4).scan({10, 0.35, 0.1});
  for (const double angle : {0.0, 0.4}) {
    Racer racer{Params{}};
    const StepResult result = racer.step(scan.view(), {3.0, 0.0, angle}, 0.025);
    EXPECT_GT(racer.trace().clearance, Params{}.velocity_profile.block_clearance) << "the path is clear";
    EXPECT_EQ(result.status, angle > 0.0 ? Status::blocked : Status::ok);
    EXPECT_EQ(result.command.speed == 0.0, angle > 0.0);
  }
}

// The planned speed at the end of the path, in a corridor of 1.6 m that narrows to `passage` [m] ahead of the car.
double speed_at_the_end(double passage, const Params& params) {
  scene::Scene funnel;
  for (const int side : {scene::right, scene::left})
    funnel.add(side, {{-5, 0.8 * side}, {1, 0.8 * side}, {4, 0.5 * passage * side}, {6, 0.5 * passage * side}});
  Racer racer{params};
  settle(racer, funnel.scan({0, 0, 0}), 2.0);
  EXPECT_GT(racer.trace().path.size(), 20U);
  return racer.trace().path.empty() ? -1.0 : racer.trace().path.back().velocity;
}

TEST(RacerSafety, before_anything_closer_to_the_path_than_block_clearance_the_plan_ends_in_a_stop) {
  Params params;
  constexpr double passage = 0.5;
  const double beside = 0.5 * (passage - params.car.width);  // 0.095 m
  params.velocity_profile.block_clearance = beside - 0.04;
  EXPECT_GT(speed_at_the_end(passage, params), 0.5);
  params.velocity_profile.block_clearance = beside + 0.04;
  EXPECT_EQ(speed_at_the_end(passage, params), 0.0);
}

TEST(RacerSafety, where_the_track_becomes_too_narrow_the_plan_ends_in_a_stop) {
  Params params;
  params.segmentation.pass_ratio = params.segmentation.pass_min = 0.1;  // any gap is passable
  params.velocity_profile.block_clearance = -0.5;                       // and nothing on the path is an obstacle
  EXPECT_EQ(speed_at_the_end(params.car.width - 0.04, params), 0.0);
  EXPECT_GT(speed_at_the_end(2.0 * params.car.width, params), 0.5);
}

TEST(RacerSafety, every_status_has_a_name) {
  for (const Status s :
       {Status::ok, Status::holding, Status::no_path, Status::blocked, Status::bad_scan, Status::bad_state})
    EXPECT_STRNE(to_string(s), "unknown");
}

}  // namespace
}  // namespace firstlap
