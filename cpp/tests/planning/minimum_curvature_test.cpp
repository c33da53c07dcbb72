#include "firstlap/planning/minimum_curvature.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "firstlap/planning/trajectory.hpp"
#include "support/random_inputs.hpp"
#include "support/scene.hpp"

namespace firstlap {
namespace {

constexpr double margin = 0.3;

MinimumCurvatureParams with_passes() {
  MinimumCurvatureParams params;
  params.bend_passes = 30;
  return params;
}

// The medial line of a lane of this width, in base_link at `car`.
Buffer<CenterlinePoint> line_of(const scene::Course& course, double from, double to, double width, const Pose2& car) {
  Buffer<CenterlinePoint> line(max_line_points);
  const double c = std::cos(car.yaw);
  const double s = std::sin(car.yaw);
  for (double along = from; along < to; along += 0.15) {
    const Pose2 p = course.at(along);
    const double dx = p.x - car.x;
    const double dy = p.y - car.y;
    line.push({c * dx + s * dy, -s * dx + c * dy, width, WallSupport::both, {}, {}});
  }
  return line;
}

struct Result {
  Buffer<Point2> smoothed{max_line_points};
  Buffer<Point2> points{max_line_points};
  Buffer<ControlPoint> control_points{max_control_points};
  bool found = false;
};

Result optimize(const Buffer<CenterlinePoint>& line, const MinimumCurvatureParams& curvature_params,
                double curvature = 0.0) {
  Result result;
  Params params;
  params.minimum_curvature = curvature_params;
  params.trajectory.smoothing_margin = margin;
  smooth_between_walls(line, params.car, params.trajectory, result.smoothed);
  result.points.assign(result.smoothed.span());
  result.found = minimum_curvature_path(line, {curvature, 0.5 * params.car.width + params.trajectory.smoothing_margin},
                                        params.minimum_curvature, result.control_points, result.points);
  return result;
}

// [1/m] of the path through these control points, ahead of base_link and up to `to` meters.
double sharpest(const Buffer<Point2>& knots, double to) {
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(knots, 0.1, 0.5, spline, path);
  double most = 0.0;
  for (const TrajectoryPoint& p : path)
    if (p.x > 0.0 && p.s < to) most = std::max(most, std::abs(p.curvature));
  return most;
}

// A right angle to the left after 4 m, with a radius of 1.5 m.
scene::Course corner() { return scene::Course{}.straight(6.0).turn(1.5, 0.5 * std::numbers::pi).straight(6.0); }

TEST(MinimumCurvature, a_car_in_the_middle_of_a_straight_goes_straight_on) {
  const auto result = optimize(line_of(scene::Course{}.straight(12.0), 1.1, 11.0, 2.0, {2.0, 0.0, 0.0}), with_passes());
  ASSERT_TRUE(result.found);
  for (const Point2& p : result.points) EXPECT_NEAR(p.y, 0.0, 1e-9);
}

TEST(MinimumCurvature, the_path_starts_on_the_arc_of_the_car) {
  for (const double curvature : {-0.8, 0.0, 0.4}) {
    const auto params = with_passes();
    const auto result =
        optimize(line_of(scene::Course{}.straight(12.0), 1.1, 11.0, 2.0, {2.0, 0.3, 0.1}), params, curvature);
    ASSERT_TRUE(result.found);
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_NEAR(result.points[i].y, 0.5 * curvature * result.points[i].x * result.points[i].x, 1e-12);
    EXPECT_DOUBLE_EQ(result.points[1].x, params.bend_lead);
    EXPECT_DOUBLE_EQ(result.points[0].x, params.bend_lead - params.bend_spacing);
  }
}

TEST(MinimumCurvature, it_swings_out_before_a_corner_cuts_it_and_has_less_curvature_than_the_smoothed_line) {
  const scene::Course course = corner();
  const auto line = line_of(course, 1.1, 12.0, 3.0, {2.0, 0.0, 0.0});
  const auto result = optimize(line, with_passes());
  ASSERT_TRUE(result.found);
  double out = 0.0;
  double in = 0.0;
  for (const ControlPoint& point : result.control_points) {
    out = std::min(out, point.offset);
    in = std::max(in, point.offset);
  }
  EXPECT_LT(out, -0.05);  // to the right before a left-hand corner
  EXPECT_GT(in, 0.1);
  EXPECT_LT(sharpest(result.points, 9.0), 0.8 * sharpest(result.smoothed, 9.0));
}

TEST(MinimumCurvature, a_mirrored_track_gives_the_mirrored_path) {
  const auto left = optimize(line_of(corner(), 1.1, 12.0, 2.0, {2.0, 0.2, 0.1}), with_passes(), 0.2);
  const scene::Course mirror = scene::Course{}.straight(6.0).turn(1.5, -0.5 * std::numbers::pi).straight(6.0);
  const auto right = optimize(line_of(mirror, 1.1, 12.0, 2.0, {2.0, -0.2, -0.1}), with_passes(), -0.2);
  ASSERT_EQ(left.points.size(), right.points.size());
  for (std::size_t i = 0; i < left.points.size(); ++i) {
    EXPECT_NEAR(left.points[i].x, right.points[i].x, 1e-9);
    EXPECT_NEAR(left.points[i].y, -right.points[i].y, 1e-9);
  }
}

// All control points but those on the car's arc; random lanes, positions and headings.
TEST(MinimumCurvature, no_control_point_comes_closer_to_a_wall_than_the_margin) {
  const auto seed = scene::seed_or(3);
  scene::RandomInputs random(seed);
  for (int run = 0; run < scene::count_or(300); ++run) {
    const double width = random.uniform(1.0, 4.0);
    const double radius = random.uniform(0.5 * width + 0.2, 4.0);
    const double angle = random.uniform(-2.5, 2.5);
    const scene::Course course = scene::Course{}.straight(5.0).turn(radius, angle).straight(8.0);
    const Pose2 car = course.at(random.uniform(1.0, 5.0), random.uniform(-0.2, 0.2));
    const auto line = line_of(course, 0.2, 12.0, width, car);
    const auto result = optimize(line, with_passes(), random.uniform(-0.5, 0.5));
    if (!result.found) continue;
    const double clearance = std::max(0.0, 0.5 * width - 0.5 * CarGeometry{}.width - margin);
    for (std::size_t i = 2; i < result.points.size(); ++i) {
      const double off = course.distance(scene::to_world(car, result.points[i].x, result.points[i].y));
      ASSERT_LE(off, clearance + 0.02) << scene::how_to_repeat(seed, run);  // the medial line is a polyline
    }
  }
}

TEST(MinimumCurvature, toward_the_end_of_the_line_the_path_returns_to_it) {
  const auto result = optimize(line_of(scene::Course{}.straight(14.0), 1.1, 12.0, 2.0, {2.0, 0.0, 0.0}), with_passes());
  ASSERT_TRUE(result.found);
  const auto free = [&](std::size_t i) { return result.control_points[i].high - result.control_points[i].low; };
  const std::size_t last = result.control_points.size() - 1;
  EXPECT_LT(free(last), 0.35 * free(2));
  for (std::size_t i = 3; i <= last; ++i) EXPECT_LE(free(i), free(i - 1) + 1e-9);
}

TEST(MinimumCurvature, no_passes_or_a_line_too_short_change_nothing) {
  const auto whole = line_of(scene::Course{}.straight(12.0), 1.1, 11.0, 2.0, {2.0, 0.3, 0.0});
  const auto brief = line_of(scene::Course{}.straight(12.0), 1.1, 3.5, 2.0, {2.0, 0.3, 0.0});
  for (const auto& [line, params] : {std::pair{whole, MinimumCurvatureParams{}}, std::pair{brief, with_passes()}}) {
    const auto result = optimize(line, params);
    EXPECT_FALSE(result.found);
    ASSERT_EQ(result.points.size(), result.smoothed.size());
    for (std::size_t i = 0; i < result.points.size(); ++i) EXPECT_EQ(result.points[i].y, result.smoothed[i].y);
  }
}

// The energy at convergence, compared with other paths through the same corner.
TEST(MinimumCurvature, many_passes_minimize_the_integral_of_squared_curvature) {
  auto params = with_passes();
  params.bend_passes = 200;
  auto result = optimize(line_of(corner(), 1.1, 12.0, 2.0, {2.0, 0.2, 0.0}), params);
  ASSERT_TRUE(result.found);
  const auto energy = [&] {
    double sum = 0.0;
    for (std::size_t i = 1; i + 1 < result.control_points.size(); ++i) {
      const Point2& a = result.control_points[i - 1].at;
      const Point2& b = result.control_points[i].at;
      const Point2& c = result.control_points[i + 1].at;
      const double before = std::hypot(b.x - a.x, b.y - a.y);
      const double after = std::hypot(c.x - b.x, c.y - b.y);
      const double turn =
          std::hypot((c.x - b.x) / after - (b.x - a.x) / before, (c.y - b.y) / after - (b.y - a.y) / before);
      sum += 2.0 * turn * turn / (before + after);
    }
    return sum;
  };
  const double least = energy();
  scene::RandomInputs random(scene::seed_or(5));
  const Buffer<ControlPoint> rest = result.control_points;
  for (int run = 0; run < 200; ++run) {
    for (std::size_t i = 2; i < rest.size(); ++i) {
      ControlPoint& point = result.control_points[i];
      const double offset = std::clamp(rest[i].offset + random.uniform(-0.15, 0.15), point.low, point.high);
      point.at = {point.on_line.x + offset * point.normal.x, point.on_line.y + offset * point.normal.y};
    }
    EXPECT_GT(energy(), 0.99 * least) << run;
  }
}

TEST(MinimumCurvature, a_car_drives_corners_and_a_hairpin_along_it) {
  Params params;
  params.minimum_curvature = with_passes();
  params.trajectory.smoothing_margin = 0.2;
  const scene::Course course =
      scene::Course{}.straight(4.0).turn(1.5, 1.5).straight(2.0).turn(1.5, -1.5).straight(2.0).turn(1.2, 3.1).straight(
          5.0);
  Racer racer(params);
  const scene::Scene walls = course.walls(2.0);
  const scene::Tour tour = scene::drive(racer, walls, course, 1.0, course.length() - 4.0, 1.0);
  EXPECT_EQ(tour.not_ok, 0);
  EXPECT_LT(tour.worst_offset, 1.0 - 0.155);
  EXPECT_GT(tour.worst_offset, 0.1);  // it does cut the corner
}

}  // namespace
}  // namespace firstlap
