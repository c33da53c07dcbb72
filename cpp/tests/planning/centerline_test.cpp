#include "firstlap/planning/centerline.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap {
namespace {

void push_wall(WallSide& side, double x0, double y0, double x1, double y1, bool ends_seen = true) {
  const double length = std::hypot(x1 - x0, y1 - y0);
  const Point2 along{(x1 - x0) / length, (y1 - y0) / length};
  const int n = static_cast<int>(length / 0.15);
  for (int i = 0; i <= n; ++i) {
    Point2 out{};
    if (ends_seen && i == 0) out = {-along.x, -along.y};
    if (ends_seen && i == n) out = along;
    side.push(x0 + (x1 - x0) * i / n, y0 + (y1 - y0) * i / n, out, 0.0F);
  }
}

Sight mirrored(const Sight& sight) { return {sight.x, -sight.y, -sight.shadow, sight.track_continues}; }

// The line of sight from the LiDAR past a point.
Sight sight_past(double x, double y, float shadow) {
  const double length = std::hypot(x - CarGeometry{}.laser_x, y);
  return {static_cast<float>((x - CarGeometry{}.laser_x) / length), static_cast<float>(y / length), shadow, true};
}

LocalWalls corridor(double y_right, double y_left, double length = 12.0) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, y_right, length, y_right);
  push_wall(walls.left, -2.0, y_left, length, y_left);
  return walls;
}

Centerline trace(const LocalWalls& walls, double width = 2.0, const Buffer<TrailPoint>& trail = Buffer<TrailPoint>(1)) {
  Centerline line;
  trace_centerline({walls, trail, width}, {CarGeometry{}, TrackWidthParams{}, CenterlineParams{}}, line);
  return line;
}

TEST(Centerline, between_two_walls_it_is_the_middle_and_the_width_is_exact) {
  for (const double half : {0.5, 1.0, 1.75}) {
    const Centerline line = trace(corridor(-half - 0.2, half - 0.2));
    ASSERT_GT(line.points.size(), 40U);
    for (const CenterlinePoint& p : line.points) {
      EXPECT_NEAR(p.y, -0.2, 0.005) << half;
      if (p.support == WallSupport::both) {
        EXPECT_NEAR(p.width, 2.0 * half, 0.01);
      }
    }
  }
}

TEST(Centerline, it_starts_0_9_m_behind_the_front_axle_and_ends_at_most_9_m_ahead) {
  const Centerline line = trace(corridor(-1.0, 1.0, 20.0));
  EXPECT_NEAR(line.points.front().x, CarGeometry{}.wheelbase - 0.9, 0.16);
  EXPECT_NEAR(line.points.back().x, CarGeometry{}.wheelbase + 9.0, 0.16);
  EXPECT_NEAR(line.ahead, 9.0, 0.16);
  EXPECT_EQ(line.end, LineEnd::length);
  EXPECT_NEAR(line.points[line.nearest].x, CarGeometry{}.wheelbase, 0.1);
}

TEST(Centerline, a_single_wall_is_offset_by_half_the_remembered_width) {
  for (const double width : {1.2, 2.0}) {
    LocalWalls walls;
    push_wall(walls.left, -2.0, 0.7, 10.0, 0.7);
    for (const CenterlinePoint& p : trace(walls, width).points) {
      EXPECT_NEAR(p.y, 0.7 - 0.5 * width, 0.02);
      EXPECT_EQ(p.support, WallSupport::left);
    }
    LocalWalls other;
    push_wall(other.right, -2.0, -0.7, 10.0, -0.7);
    for (const CenterlinePoint& p : trace(other, width).points) EXPECT_NEAR(p.y, -0.7 + 0.5 * width, 0.02);
  }
}

TEST(Centerline, walls_farther_apart_than_width_max_are_no_pair_and_the_nearer_one_counts) {
  const TrackWidthParams params;
  for (const double side : {1.0, -1.0}) {
    const auto between = [&](double apart) {
      const double far = apart - 1.5;
      return trace(side > 0.0 ? corridor(-far, 1.5) : corridor(-1.5, far));
    };
    const Centerline wide = between(params.width_max + 0.1);
    ASSERT_GT(wide.points.size(), 40U);
    for (const CenterlinePoint& p : wide.points) {
      EXPECT_TRUE(p.wide);
      EXPECT_EQ(p.support, side > 0.0 ? WallSupport::left : WallSupport::right);
      EXPECT_NEAR(p.y * side, 1.5 - 0.5 * 2.0, 0.02) << "half the remembered width from the nearer wall";
    }
    for (const CenterlinePoint& p : between(params.width_max - 0.1).points) {
      EXPECT_FALSE(p.wide);
      EXPECT_NEAR(p.y * side, 1.5 - 0.5 * (params.width_max - 0.1), 0.02) << "still a pair";
    }
  }
}

TEST(Centerline, where_one_wall_ends_the_other_continues_with_the_measured_width) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -0.75, 10.0, -0.75);
  push_wall(walls.left, -2.0, 0.75, 3.0, 0.75);
  const Centerline line = trace(walls, 1.5);
  EXPECT_GT(line.ahead, 8.0);
  for (const CenterlinePoint& p : line.points) EXPECT_NEAR(p.y, 0.0, 0.05) << p.x;
}

TEST(Centerline, where_one_wall_ends_the_measured_width_continues_and_blends_into_the_remembered_width) {
  constexpr double measured = 1.5;
  constexpr double remembered = 2.5;
  constexpr double end = 3.0;
  LocalWalls walls;
  push_wall(walls.right, -2.0, -0.5 * measured, 10.0, -0.5 * measured);
  push_wall(walls.left, -2.0, 0.5 * measured, end, 0.5 * measured);
  const Centerline line = trace(walls, remembered);
  ASSERT_GT(line.ahead, 8.0);
  for (const CenterlinePoint& p : line.points) {
    const double faded = std::clamp((p.x - end) / TrackWidthParams{}.width_blend, 0.0, 1.0);
    EXPECT_NEAR(p.width, measured + faded * (remembered - measured), 0.1) << p.x;
  }
}

TEST(Centerline, without_walls_there_is_no_line) {
  const Centerline line = trace(LocalWalls{});
  EXPECT_EQ(line.points.size(), 0U);
  EXPECT_EQ(line.end, LineEnd::none);
}

// Every outer wall of a sharp corner folds a plain offset curve into a loop.
TEST(Centerline, a_sharp_corner_does_not_fold_it) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -1.0, 4.0, -1.0, false);
  push_wall(walls.right, 4.0, -1.0, 4.0, 8.0);
  push_wall(walls.left, -2.0, 1.0, 2.0, 1.0, false);
  push_wall(walls.left, 2.0, 1.0, 2.0, 8.0);
  const Centerline line = trace(walls);
  EXPECT_GT(line.ahead, 6.0);
  for (std::size_t i = 1; i + 1 < line.points.size(); ++i) {
    const Point2 a{line.points[i].x - line.points[i - 1].x, line.points[i].y - line.points[i - 1].y};
    const Point2 b{line.points[i + 1].x - line.points[i].x, line.points[i + 1].y - line.points[i].y};
    EXPECT_GT(a.x * b.x + a.y * b.y, 0.0) << "turns back at point " << i;
  }
  EXPECT_NEAR(line.points.back().x, 3.0, 0.05);
}

TEST(Centerline, every_point_keeps_its_distance_to_the_whole_of_both_walls) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -1.0, 4.0, -1.0, false);
  push_wall(walls.right, 4.0, -1.0, 4.0, 8.0);
  push_wall(walls.left, -2.0, 1.0, 2.0, 1.0, false);
  push_wall(walls.left, 2.0, 1.0, 2.0, 8.0);
  for (const CenterlinePoint& p : trace(walls).points) {
    const double right = nearest_sample(walls.right, p.x, p.y).distance;
    const double left = nearest_sample(walls.left, p.x, p.y).distance;
    EXPECT_GT(std::min(right, left), 0.9) << p.x << ' ' << p.y;
    EXPECT_NEAR(right, left, 0.1) << p.x << ' ' << p.y;
  }
}

TEST(Centerline, a_niche_does_not_shift_it_by_more_than_it_widens_the_track) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -1.0, 12.0, -1.0);
  push_wall(walls.left, -2.0, 1.0, 3.0, 1.0, false);
  push_wall(walls.left, 3.0, 1.0, 3.0, 1.5, false);
  push_wall(walls.left, 3.0, 1.5, 4.0, 1.5, false);
  push_wall(walls.left, 4.0, 1.5, 4.0, 1.0, false);
  push_wall(walls.left, 4.0, 1.0, 12.0, 1.0);
  const Centerline line = trace(walls);
  EXPECT_GT(line.ahead, 8.0);
  for (const CenterlinePoint& p : line.points) EXPECT_NEAR(p.y, 0.1, 0.2) << p.x;
}

TEST(Centerline, walls_narrower_than_the_car_end_it) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -1.0, 6.0, -0.05);
  push_wall(walls.left, -2.0, 1.0, 6.0, 0.05);
  const Centerline line = trace(walls);
  EXPECT_EQ(line.end, LineEnd::too_narrow);
  for (const CenterlinePoint& p : line.points) EXPECT_GT(p.width, CarGeometry{}.width);
}

TEST(Centerline, a_line_against_the_cars_own_trail_ends_there) {
  // The corridor ahead is where the car came from, driving toward its present position.
  Buffer<TrailPoint> trail(64);
  for (int i = 0; i < 20; ++i) trail.push({6.0 - 0.2 * i, 0.0, scene::pi, 3.0});
  const Centerline line = trace(corridor(-1.0, 1.0), 2.0, trail);
  EXPECT_EQ(line.end, LineEnd::turns_back);
  EXPECT_LT(line.ahead, 3.0);
}

TEST(Centerline, a_line_along_the_cars_own_trail_does_not_end) {
  Buffer<TrailPoint> trail(64);
  for (int i = 0; i < 20; ++i) trail.push({6.0 - 0.2 * i, 0.0, 0.0, 3.0});
  EXPECT_EQ(trace(corridor(-1.0, 1.0), 2.0, trail).end, LineEnd::length);
}

TEST(Centerline, around_a_column_it_ends_where_it_meets_itself) {
  const CarGeometry car;
  const double radius = 0.3;
  const double width = 1.2;
  const Point2 center{car.wheelbase, radius + 0.5 * width};
  LocalWalls walls;
  for (double angle = 0.0; angle < 2.0 * scene::pi; angle += 0.2)
    walls.left.push(center.x + radius * std::cos(angle), center.y + radius * std::sin(angle), {}, 0.0F);
  const Centerline line = trace(walls, width);
  EXPECT_EQ(line.end, LineEnd::turns_back);
  EXPECT_GT(line.ahead, 3.0);
  EXPECT_LT(line.ahead, 2.0 * scene::pi * center.y);
}

// A hairpin around the tip of the left wall, which ends beside the car: the area behind it is occluded, but the space
// up to the line of sight past it is free.
TEST(Centerline, around_a_tip_it_is_as_far_from_the_tip_as_from_the_outer_wall) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -0.7, 2.5, -0.7, false);
  push_wall(walls.right, 2.5, -0.7, 2.5, 3.0);
  push_wall(walls.left, -2.0, 0.7, 0.3, 0.7, false);
  walls.left.outward[walls.left.size() - 1] = {1.0, 0.0};
  const Centerline blind = trace(walls, 1.4);
  walls.left.sight[walls.left.size() - 1] = sight_past(0.3, 0.7, 1.0F);
  const Centerline line = trace(walls, 1.4);
  const auto offset_at_tip = [](const Centerline& at) {
    double x = 0.0;
    for (const CenterlinePoint& p : at.points)
      if (p.y < 0.7) x = std::max(x, p.x);
    return x - 0.5 * (0.3 + 2.5);  // midway between tip and outer wall
  };
  EXPECT_NEAR(offset_at_tip(line), 0.0, 0.12);
  EXPECT_GT(offset_at_tip(blind), 0.25);
}

TEST(Centerline, between_two_visible_ends_it_continues_as_far_as_both_lines_of_sight_allow) {
  const auto widening = [](bool sight) {
    LocalWalls walls;
    for (const double side : {1.0, -1.0}) {
      WallSide& wall = side > 0.0 ? walls.left : walls.right;
      push_wall(wall, -2.0, 0.5 * side, 1.5, 0.5 * side);
      if (sight) wall.sight[wall.size() - 1] = sight_past(1.5, 0.5 * side, static_cast<float>(side));
      push_wall(wall, 3.5, 1.0 * side, 9.0, 1.0 * side);
    }
    return trace(walls, 1.0);
  };
  EXPECT_LT(widening(false).ahead, 2.0);
  EXPECT_GT(widening(true).ahead, 6.0);
  for (const CenterlinePoint& p : widening(true).points) EXPECT_NEAR(p.y, 0.0, 0.02);
}

TEST(Centerline, mirrored_walls_mirror_it) {
  LocalWalls walls;
  push_wall(walls.right, -2.0, -1.0, 4.0, -1.0, false);
  push_wall(walls.right, 4.0, -1.0, 4.0, 8.0);
  push_wall(walls.left, -2.0, 1.0, 2.0, 1.0, false);
  push_wall(walls.left, 2.0, 1.0, 2.0, 8.0);
  LocalWalls mirror;
  for (std::size_t i = 0; i < walls.right.size(); ++i)
    mirror.left.push(walls.right.x[i], -walls.right.y[i], {walls.right.outward[i].x, -walls.right.outward[i].y}, 0.0F,
                     mirrored(walls.right.sight[i]));
  for (std::size_t i = 0; i < walls.left.size(); ++i)
    mirror.right.push(walls.left.x[i], -walls.left.y[i], {walls.left.outward[i].x, -walls.left.outward[i].y}, 0.0F,
                      mirrored(walls.left.sight[i]));
  const Centerline a = trace(walls);
  const Centerline b = trace(mirror);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_NEAR(a.points[i].x, b.points[i].x, 1e-9);
    EXPECT_NEAR(a.points[i].y, -b.points[i].y, 1e-9);
  }
}

TEST(Centerline, samples_beyond_the_capacity_of_a_side_are_dropped) {
  LocalWalls walls;
  for (std::size_t i = 0; i < 3 * max_samples; ++i) {
    walls.left.push(0.01 * static_cast<double>(i), 1.0, {}, 0.0F);
    walls.right.push(0.01 * static_cast<double>(i), -1.0, {}, 0.0F);
  }
  EXPECT_EQ(walls.left.size(), max_samples);
  EXPECT_LE(trace(walls).points.size(), max_line_points);
}

TEST(WallSide, the_nearest_sample_is_the_nearest_of_all) {
  WallSide side;
  EXPECT_TRUE(std::isinf(nearest_sample(side, 0.0, 0.0).distance));
  for (int i = 0; i < 37; ++i) {
    side.push(std::cos(7.0 * i) * i, std::sin(7.0 * i) * i, {}, 0.0F);
    for (const Point2 p : {Point2{0.0, 0.0}, Point2{5.0, -7.0}, Point2{-30.0, 2.0}}) {
      double best = 1e9;
      for (std::size_t k = 0; k < side.size(); ++k)
        best = std::min(best, std::hypot(static_cast<double>(side.x[k]) - p.x, static_cast<double>(side.y[k]) - p.y));
      EXPECT_NEAR(nearest_sample(side, p.x, p.y).distance, best, 1e-4);
    }
  }
}

TEST(WallSide, moving_the_car_moves_walls_in_the_opposite_direction_and_ages_them) {
  LocalWalls walls;
  walls.left.push(2.0, 1.0, {1.0, 0.0}, 0.1F);
  move_walls({1.0, 0.0, 0.5 * scene::pi}, 0.025, walls);
  EXPECT_NEAR(walls.left.x[0], 1.0, 1e-6);
  EXPECT_NEAR(walls.left.y[0], -1.0, 1e-6);
  EXPECT_NEAR(walls.left.outward[0].y, -1.0, 1e-6);
  EXPECT_NEAR(walls.left.age[0], 0.125, 1e-6);
}

}  // namespace
}  // namespace firstlap
