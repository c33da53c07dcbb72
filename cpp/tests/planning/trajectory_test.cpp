#include "firstlap/planning/trajectory.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "support/random_inputs.hpp"

namespace firstlap {
namespace {

Buffer<Point2> buffer_of(const std::vector<Point2>& points) {
  Buffer<Point2> buffer(max_line_points);
  for (const Point2& p : points) buffer.push(p);
  return buffer;
}
Buffer<CenterlinePoint> line_of(const std::vector<Point2>& points) {
  Buffer<CenterlinePoint> buffer(max_line_points);
  for (const Point2& p : points) buffer.push({p.x, p.y, 2.0, WallSupport::both, {}, {}});
  return buffer;
}
Buffer<Point2> circle(double radius, double step, int count) {
  Buffer<Point2> points(max_line_points);
  for (int i = 0; i < count; ++i) {
    const double angle = step * i / radius;
    points.push({radius * std::sin(angle), radius * (1.0 - std::cos(angle))});
  }
  return points;
}

// Laplacian smoothing ---------------------------------------------------------------------------------

// The line's points, smoothed.
void smooth_line(const Buffer<CenterlinePoint>& line, double lambda, int iterations, Buffer<Point2>& out) {
  out.clear();
  for (const CenterlinePoint& p : line) out.push({p.x, p.y});
  smooth(lambda, iterations, out);
}

TEST(Smoothing, one_pass_moves_each_point_by_lambda_toward_the_midpoint_of_its_old_neighbors) {
  Buffer<Point2> out(max_line_points);
  smooth_line(line_of({{0, 0}, {1, 1}, {2, 0}, {3, 4}, {4, 0}}), 0.5, 1, out);
  const double expected[] = {0.0, 0.5, 1.25, 2.0, 0.0};  // 1-.5*1, 0+.5*2.5, 4-.5*4
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_DOUBLE_EQ(out[i].x, static_cast<double>(i));
    EXPECT_DOUBLE_EQ(out[i].y, expected[i]);
  }
}

TEST(Smoothing, it_keeps_both_ends_and_a_straight_line) {
  std::vector<Point2> straight;
  for (int i = 0; i < 50; ++i) straight.push_back({0.15 * i, 0.3 * i});
  Buffer<Point2> out(max_line_points);
  smooth_line(line_of(straight), 0.5, 10, out);
  ASSERT_EQ(out.size(), straight.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_NEAR(out[i].x, straight[i].x, 1e-12);
    EXPECT_NEAR(out[i].y, straight[i].y, 1e-12);
  }
}

TEST(Smoothing, no_passes_or_no_lambda_is_a_copy) {
  const auto line = line_of({{0, 0}, {1, 1}, {2, 0}});
  Buffer<Point2> out(max_line_points);
  smooth_line(line, 0.5, 0, out);
  EXPECT_DOUBLE_EQ(out[1].y, 1.0);
  smooth_line(line, 0.0, 10, out);
  EXPECT_DOUBLE_EQ(out[1].y, 1.0);
}

// The response to a single peak is a bell of variance N lambda ds^2: sigma = ds sqrt(lambda N) = 0.34 m.
TEST(Smoothing, its_reach_is_ds_times_the_root_of_lambda_n) {
  constexpr double ds = 0.15;
  std::vector<Point2> peak;
  for (int i = 0; i < 101; ++i) peak.push_back({ds * i, i == 50 ? 1.0 : 0.0});
  Buffer<Point2> out(max_line_points);
  smooth_line(line_of(peak), 0.5, 10, out);
  double sum = 0.0;
  double variance = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double d = ds * (static_cast<double>(i) - 50.0);
    sum += out[i].y;
    variance += out[i].y * d * d;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(std::sqrt(variance), ds * std::sqrt(0.5 * 10), 1e-9);
}

TEST(Smoothing, it_shrinks_a_circle_by_half_sigma_squared_times_its_curvature) {
  constexpr double ds = 0.15;
  constexpr double radius = 2.0;
  const Buffer<Point2> arc = circle(radius, ds, 80);
  std::vector<Point2> points(arc.begin(), arc.end());
  Buffer<Point2> out(max_line_points);
  smooth_line(line_of(points), 0.5, 10, out);
  const double shrink = 0.5 * ds * ds * 0.5 * 10 / radius;  // 0.028 m
  EXPECT_NEAR(radius - std::hypot(out[40].x, out[40].y - radius), shrink, 0.03 * shrink);
}

// Opheim ----------------------------------------------------------------------------------------------

// Worked out by hand from the pseudocode in method.md, section 6, with tol_min 0.1 and tol_max 1.
struct Worked {
  const char* name;
  std::vector<Point2> points;
  std::vector<std::size_t> knots;
};
const Worked worked[] = {
    {"a straight line keeps the last point before the longest step",
     {{0, 0}, {0.3, 0}, {0.6, 0}, {0.9, 0}, {1.2, 0}, {1.5, 0}, {1.8, 0}},
     {0, 3, 6}},
    {"a corner is kept", {{0, 0}, {0.3, 0}, {0.6, 0}, {0.6, 0.3}, {0.6, 0.6}}, {0, 2, 4}},
    {"points within tol_min of the kept point do not define the ray",
     {{0, 0}, {0.02, 0.02}, {0.05, 0}, {0.5, 0}, {0.8, 0}, {0.8, 0.5}},
     {0, 4, 5}},
    {"the ray is a half-line: points behind the kept point are far from it",
     {{0, 0}, {0.3, 0}, {0.5, 0}, {-0.3, 0}},
     {0, 2, 3}},
    {"points behind but near the kept point are dropped",
     {{0, 0}, {0.3, 0}, {0.5, 0}, {-0.05, 0}, {-0.05, -0.02}},
     {0, 4}},
    {"a step of exactly tol_max ends the reach of the kept point", {{0, 0}, {0.5, 0}, {1, 0}, {1.5, 0}}, {0, 1, 2, 3}},
    {"an offset of exactly tol_min is kept", {{0, 0}, {0.25, 0}, {0.5, 0.1}, {0.75, 0.1}}, {0, 1, 3}},
    {"three points", {{0, 0}, {0.25, 0.25}, {0.5, 0}}, {0, 1, 2}},
    {"two points are copied", {{0, 0}, {0.01, 0}}, {0, 1}},
    {"one point is copied", {{1, 2}}, {0}},
    {"no points", {}, {}},
};

TEST(Opheim, it_agrees_with_vectors_worked_by_hand) {
  for (const Worked& w : worked) {
    Buffer<Point2> knots(max_line_points);
    simplify_opheim(buffer_of(w.points), 0.1, 1.0, knots);
    ASSERT_EQ(knots.size(), w.knots.size()) << w.name;
    for (std::size_t i = 0; i < knots.size(); ++i) {
      EXPECT_EQ(knots[i].x, w.points[w.knots[i]].x) << w.name << ", kept point " << i;
      EXPECT_EQ(knots[i].y, w.points[w.knots[i]].y) << w.name << ", kept point " << i;
    }
  }
}

TEST(Opheim, a_zero_tolerance_is_a_copy) {
  const auto points = buffer_of({{0, 0}, {0.1, 0}, {0.2, 0}, {0.3, 0}});
  Buffer<Point2> knots(max_line_points);
  simplify_opheim(points, 0.0, 1.0, knots);
  EXPECT_EQ(knots.size(), 4U);
  simplify_opheim(points, 0.1, 0.0, knots);
  EXPECT_EQ(knots.size(), 4U);
}

TEST(Opheim, kept_points_are_in_order_and_include_both_ends) {
  const auto seed = scene::seed_or(1);
  scene::RandomInputs random(seed);
  for (int run = 0; run < scene::count_or(1000); ++run) {
    Buffer<Point2> points(max_line_points);
    const int n = random.integer(3, 100);
    for (int i = 0; i < n; ++i) points.push({0.15 * i, random.uniform(-0.1, 0.1)});
    Buffer<Point2> knots(max_line_points);
    simplify_opheim(points, 0.03, 1.0, knots);
    std::size_t at = 0;
    for (const Point2& knot : knots) {
      while (at < points.size() && (points[at].x != knot.x || points[at].y != knot.y)) ++at;
      ASSERT_LT(at, points.size()) << scene::how_to_repeat(seed, run);
    }
    ASSERT_EQ(knots.front().x, points.front().x);
    ASSERT_EQ(knots.back().x, points.back().x);
  }
}

// The path --------------------------------------------------------------------------------------------

TEST(Path, the_curvature_of_a_circle_is_one_over_its_radius_also_at_its_end) {
  for (const double radius : {0.8, 2.0, 5.0}) {
    Spline spline(max_line_points);
    Buffer<TrajectoryPoint> path(max_path_points);
    sample_path(circle(radius, 0.3, 16), 0.1, 0.5, spline, path);
    ASSERT_GT(path.size(), 30U);
    for (std::size_t i = 5; i < path.size(); ++i) EXPECT_NEAR(path[i].curvature * radius, 1.0, 0.08) << i;
  }
}

TEST(Path, arc_length_is_the_sum_of_its_steps_and_steps_are_the_sample_distance) {
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(circle(2.0, 0.15, 40), 0.1, 0.5, spline, path);
  double s = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step = std::hypot(path[i].x - path[i - 1].x, path[i].y - path[i - 1].y);
    s += step;
    EXPECT_NEAR(path[i].s, s, 1e-12);
    EXPECT_NEAR(step, 0.1, 0.002);
  }
}

TEST(Path, its_yaw_is_the_direction_of_travel) {
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(circle(2.0, 0.15, 60), 0.1, 0.5, spline, path);
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const double yaw = std::atan2(path[i + 1].y - path[i - 1].y, path[i + 1].x - path[i - 1].x);
    EXPECT_NEAR(std::remainder(path[i].yaw - yaw, 2.0 * std::numbers::pi), 0.0, 0.01);
  }
}

TEST(Path, points_beyond_the_capacity_are_dropped) {
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(buffer_of({{0, 0}, {100, 0}, {200, 1}}), 0.1, 0.5, spline, path);
  EXPECT_EQ(path.size(), max_path_points);
}

TEST(Path, fewer_than_two_different_points_give_no_path) {
  Spline spline(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  sample_path(buffer_of({}), 0.1, 0.5, spline, path);
  EXPECT_TRUE(path.empty());
  sample_path(buffer_of({{1, 1}, {1, 1}}), 0.1, 0.5, spline, path);
  EXPECT_TRUE(path.empty());
}

TEST(Path, the_nearest_point_is_the_nearest_of_all) {
  Buffer<TrajectoryPoint> path(8);
  for (int i = 0; i < 5; ++i) path.push({0.1 * i, 0.1 * i, 0.0, 0.0, 0.0, 0.0});
  EXPECT_EQ(nearest_on_path(path, 0.31, 2.0), 3U);
  EXPECT_EQ(nearest_on_path(path, -5.0, 0.0), 0U);
  EXPECT_EQ(nearest_on_path(path, 5.0, 0.0), 4U);
}

// The join to the car ---------------------------------------------------------------------------------

TEST(Smoothing, between_walls_no_point_comes_closer_than_the_margin) {
  Buffer<CenterlinePoint> line(max_line_points);
  for (int i = 0; i <= 20; ++i) line.push({0.15 * i, 0.0, 1.4, WallSupport::both, {}, {}});
  for (int i = 1; i <= 20; ++i) line.push({3.0, 0.15 * i, 1.4, WallSupport::both, {}, {}});
  TrajectoryParams params;
  params.smoothing_iterations = 200;
  params.smoothing_margin = 0.3;
  const CarGeometry car;
  const double slack = 0.5 * 1.4 - 0.5 * car.width - params.smoothing_margin;
  Buffer<Point2> points(max_line_points);
  smooth_between_walls(line, car, params, points);
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    farthest = std::max(farthest, std::hypot(points[i].x - line[i].x, points[i].y - line[i].y));
  EXPECT_LE(farthest, slack + 1e-12);
  EXPECT_GT(farthest, 0.9 * slack);  // it cuts the corner as far as allowed
}

Buffer<Point2> straight_line(double y, double yaw) {
  Buffer<Point2> points(max_line_points);
  for (int i = -6; i < 60; ++i) points.push({0.33 + 0.15 * i * std::cos(yaw), y + 0.15 * i * std::sin(yaw)});
  return points;
}

TEST(Join, a_line_that_the_car_is_on_stays_unchanged) {
  Buffer<Point2> points = straight_line(0.0, 0.0);
  join_car(1.5, 0.78, points);
  for (const Point2& p : points) EXPECT_NEAR(p.y, 0.0, 1e-12);
}

TEST(Join, the_path_leaves_base_link_along_the_cars_heading) {
  for (const double y : {-0.5, 0.3}) {
    for (const double yaw : {-0.4, 0.0, 0.4}) {
      Buffer<Point2> points = straight_line(y, yaw);
      join_car(1.5, 0.78, points);
      double nearest = 1e9;
      double slope = 1e9;
      for (std::size_t i = 1; i < points.size(); ++i) {
        const double d = std::hypot(0.5 * (points[i].x + points[i - 1].x), 0.5 * (points[i].y + points[i - 1].y));
        if (d < nearest) {
          nearest = d;
          slope = std::atan2(points[i].y - points[i - 1].y, points[i].x - points[i - 1].x);
        }
      }
      EXPECT_LT(nearest, 0.09) << y << ' ' << yaw;  // half a step and a little
      EXPECT_NEAR(slope, 0.0, 0.12) << y << ' ' << yaw;
    }
  }
}

TEST(Join, after_the_join_distance_it_is_the_line_again) {
  for (const double distance : {1.0, 1.5, 4.0}) {
    Buffer<Point2> points = straight_line(0.4, 0.0);
    join_car(distance, 0.78, points);
    for (const Point2& p : points) {
      if (p.x > 0.33 + distance) {
        EXPECT_NEAR(p.y, 0.4, 1e-12);
      }
    }
  }
}

TEST(Join, no_distance_changes_nothing) {
  Buffer<Point2> points = straight_line(0.4, 0.2);
  const std::vector<Point2> before(points.begin(), points.end());
  join_car(0.0, 0.78, points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].y, before[i].y);
}

TEST(Join, it_joins_the_line_without_a_jump) {
  Buffer<Point2> points = straight_line(0.4, 0.0);
  join_car(2.0, 0.78, points);
  for (std::size_t i = 1; i < points.size(); ++i) EXPECT_LT(std::abs(points[i].y - points[i - 1].y), 0.07) << i;
}

TEST(Join, it_never_overshoots_the_line_from_a_parallel_start) {
  Buffer<Point2> points = straight_line(0.4, 0.0);
  join_car(2.0, 0.78, points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_GE(points[i].y, -1e-9);
    EXPECT_LE(points[i].y, 0.4 + 1e-9);
  }
}

// A straight path `y` [m] to the left of base_link, along x.
Buffer<TrajectoryPoint> straight_path(double y) {
  Buffer<TrajectoryPoint> path(max_path_points);
  for (int i = 0; i < 60; ++i) path.push({.s = 0.1 * i, .x = -0.9 + 0.1 * i, .y = y});
  return path;
}

TEST(JoinPrevious, the_path_begins_at_the_previous_one_and_decays_to_the_line) {
  constexpr double reach = 1.2;
  Buffer<Point2> points = straight_line(0.4, 0.0);
  join_previous(straight_path(0.1), reach, points);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double residual = -0.3 * std::exp(-std::max(points[i].x, 0.0) / reach);
    EXPECT_NEAR(points[i].y, 0.4 + residual, 1e-9) << i;
  }
}

TEST(JoinPrevious, a_car_beside_the_path_changes_nothing) {
  Buffer<Point2> points = straight_line(0.4, 0.0);
  join_previous(straight_path(0.4), 1.2, points);
  for (const Point2& p : points) EXPECT_NEAR(p.y, 0.4, 1e-12) << "the cross-track term has to bring the car back";
}

TEST(JoinPrevious, without_a_previous_path_the_path_begins_at_the_car) {
  Buffer<Point2> points = straight_line(0.4, 0.0);
  join_previous(Buffer<TrajectoryPoint>(max_path_points), 1.2, points);
  for (std::size_t i = 0; i + 1 < points.size() && points[i].x <= 0.0; ++i) EXPECT_NEAR(points[i].y, 0.0, 1e-9) << i;
}

TEST(JoinPrevious, the_scan_rate_does_not_change_the_curve) {
  constexpr double reach = 1.5;
  constexpr double driven = 0.5;
  // The car's distance to the path is measured across the path, which has a slope there: a cosine.
  const double slack = 0.4 * (1.0 - std::cos(std::atan(0.4 / reach)));
  Buffer<Point2> once = straight_line(0.4, 0.0);
  join_previous(straight_path(0.0), reach, once);
  // Half a meter later: the previous path is the one above, moved by odometry.
  Buffer<TrajectoryPoint> previous(max_path_points);
  for (const Point2& p : once) previous.push({.x = p.x - driven, .y = p.y});
  Buffer<Point2> again = straight_line(0.4, 0.0);
  join_previous(previous, reach, again);
  for (std::size_t i = 0; i + 1 < again.size(); ++i) {
    if (again[i].x < 0.0 || again[i].x > 3.0) continue;
    EXPECT_NEAR(again[i].y, 0.4 - 0.4 * std::exp(-(again[i].x + driven) / reach), slack) << i;
  }
}

TEST(JoinPrevious, no_reach_changes_nothing) {
  Buffer<Point2> points = straight_line(0.4, 0.2);
  const std::vector<Point2> before(points.begin(), points.end());
  join_previous(straight_path(0.0), 0.0, points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(points[i].y, before[i].y);
}

}  // namespace
}  // namespace firstlap
