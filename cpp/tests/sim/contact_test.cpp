#include "firstlap/sim/contact.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "firstlap/common/rng.hpp"

namespace firstlap::sim {
namespace {

// Independent distance of a map point to the car's rectangle.
double point_to_car(const CarGeometry& car, const Pose2& pose, Point2 p) {
  const double dx = p.x - pose.x, dy = p.y - pose.y;
  const double x = std::cos(pose.yaw) * dx + std::sin(pose.yaw) * dy;
  const double y = std::cos(pose.yaw) * dy - std::sin(pose.yaw) * dx;
  const double ox = std::max({-car.rear_overhang - x, 0.0, x - (car.length - car.rear_overhang)});
  const double oy = std::max(std::abs(y) - 0.5 * car.width, 0.0);
  return std::hypot(ox, oy);
}

double sampled_clearance(const CarGeometry& car, const Pose2& pose, const WallSegment& w, int samples) {
  double best = 1e9;
  for (int i = 0; i <= samples; ++i) {
    const double t = static_cast<double>(i) / samples;
    best = std::min(best, point_to_car(car, pose, {w.x1 + t * (w.x2 - w.x1), w.y1 + t * (w.y2 - w.y1)}));
  }
  return best;
}

TEST(Contact, clearance_equals_dense_sampling_of_the_segment) {
  Rng rng(21);
  const CarGeometry car;
  int touching = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    const Pose2 pose{rng.uniform(), rng.uniform(), 10.0 * rng.uniform()};
    const WallSegment w{3.0 * rng.uniform() - 1.0, 3.0 * rng.uniform() - 1.0, 3.0 * rng.uniform() - 1.0,
                        3.0 * rng.uniform() - 1.0};
    const double sampled = sampled_clearance(car, pose, w, 2000), exact = clearance(car, pose, w);
    ASSERT_LE(exact, sampled + 1e-12);
    ASSERT_GE(exact, sampled - 1.1e-3);  // half a sample of at most 4.3 m / 2000
    ASSERT_EQ(exact == 0.0, touch(car, pose, w).has_value());
    touching += exact == 0.0;
  }
  EXPECT_GT(touching, 500);
}

TEST(Contact, touch_point_lies_in_the_car_and_on_the_segment) {
  Rng rng(22);
  const CarGeometry car;
  for (int trial = 0; trial < 5000; ++trial) {
    const Pose2 pose{rng.uniform(), rng.uniform(), 10.0 * rng.uniform()};
    const WallSegment w{3.0 * rng.uniform() - 1.0, 3.0 * rng.uniform() - 1.0, rng.uniform(), rng.uniform()};
    const auto point = touch(car, pose, w);
    if (!point) continue;
    ASSERT_NEAR(point_to_car(car, pose, *point), 0.0, 1e-12);
    ASSERT_NEAR(distance(*point, w), 0.0, 1e-12);
  }
}

TEST(Contact, nose_touches_exactly_at_the_bumper) {
  const CarGeometry car;  // bumper 0.455 m ahead of the rear axle
  const Walls wall({{1.0, -1.0, 1.0, 1.0}});
  const double bumper = car.length - car.rear_overhang;
  EXPECT_NEAR(clearance(car, {0.4, 0.0, 0.0}, wall), 0.6 - bumper, 1e-12);
  EXPECT_FALSE(touch(car, {1.0 - bumper - 1e-9, 0.0, 0.0}, wall).has_value());
  EXPECT_TRUE(touch(car, {1.0 - bumper + 1e-9, 0.0, 0.0}, wall).has_value());
  EXPECT_TRUE(touch(car, {1.0 + car.rear_overhang - 1e-9, 0.0, 0.0}, wall).has_value());
  EXPECT_FALSE(touch(car, {1.0 + car.rear_overhang + 1e-9, 0.0, 0.0}, wall).has_value());
}

TEST(Contact, walls_that_are_not_solid_do_not_count) {
  const CarGeometry car;
  const Walls walls({{0.2, -1.0, 0.2, 1.0, true, false}, {3.0, -1.0, 3.0, 1.0}});
  EXPECT_FALSE(touch(car, {}, walls).has_value());
  EXPECT_NEAR(clearance(car, {}, walls), 3.0 - 0.455, 1e-12);
}

TEST(Contact, against_walls_equals_the_nearest_segment) {
  Rng rng(23);
  const CarGeometry car;
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<WallSegment> segments;
    for (int i = 0; i < 20; ++i) {
      const double x = 20.0 * rng.uniform(), y = 20.0 * rng.uniform();
      segments.push_back({x, y, x + rng.uniform(), y + rng.uniform()});
    }
    const Walls walls(segments);
    const Pose2 pose{30.0 * rng.uniform() - 5.0, 30.0 * rng.uniform() - 5.0, rng.gaussian()};
    double expected = 1e9;
    for (const WallSegment& w : segments) expected = std::min(expected, clearance(car, pose, w));
    ASSERT_DOUBLE_EQ(clearance(car, pose, walls), expected);
    ASSERT_EQ(touch(car, pose, walls).has_value(), expected == 0.0);
  }
}

}  // namespace
}  // namespace firstlap::sim
