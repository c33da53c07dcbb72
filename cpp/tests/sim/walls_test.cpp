#include "firstlap/sim/walls.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include "firstlap/common/rng.hpp"

namespace firstlap::sim {
namespace {

std::vector<WallSegment> random_walls(Rng& rng, int count, double longest) {
  std::vector<WallSegment> segments;
  for (int i = 0; i < count; ++i) {
    const double x = 30.0 * rng.uniform(), y = 30.0 * rng.uniform();
    const double dx = longest * (rng.uniform() - 0.5), dy = longest * (rng.uniform() - 0.5);
    segments.push_back({x, y, x + dx, y + dy, true, i % 4 != 0});
  }
  return segments;
}

TEST(Walls, finds_exactly_the_segments_within_a_radius) {
  Rng rng(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Walls walls(random_walls(rng, 100, trial % 2 == 0 ? 1.0 : 30.0), 0.3 + rng.uniform());
    const Point2 center{50.0 * rng.uniform() - 10.0, 50.0 * rng.uniform() - 10.0};
    const double radius = 10.0 * rng.uniform();
    std::vector<std::uint32_t> found(100);
    found.resize(walls.near(center, radius, found));
    std::set<std::uint32_t> expected;
    for (std::uint32_t i = 0; i < 100; ++i) {
      if (distance(center, walls.segments()[i]) <= radius) expected.insert(i);
    }
    ASSERT_EQ(std::set(found.begin(), found.end()), expected);
    ASSERT_EQ(found.size(), expected.size()) << "a segment was reported twice";
  }
}

TEST(Walls, nearest_distance_equals_brute_force_over_solid_segments) {
  Rng rng(2);
  for (int trial = 0; trial < 500; ++trial) {
    const Walls walls(random_walls(rng, 1 + trial % 40, 5.0));
    const Point2 point{200.0 * (rng.uniform() - 0.5), 200.0 * (rng.uniform() - 0.5)};
    double expected = std::numeric_limits<double>::infinity();
    for (const WallSegment& s : walls.segments()) {
      if (s.solid) expected = std::min(expected, distance(point, s));
    }
    ASSERT_EQ(walls.nearest_distance(point), expected);
  }
}

TEST(Walls, counts_more_than_fit_in_the_buffer) {
  const Walls walls({{0, 0, 1, 0}, {0, 1, 1, 1}, {0, 2, 1, 2}});
  std::vector<std::uint32_t> found(1);
  EXPECT_EQ(walls.near({0.5, 1.0}, 5.0, found), 3U);
}

TEST(Walls, are_empty_without_segments) {
  const Walls walls;
  EXPECT_EQ(walls.near({0, 0}, 1e6, {}), 0U);
  EXPECT_TRUE(std::isinf(walls.nearest_distance({0, 0})));
  EXPECT_TRUE(std::isinf(walls.raycast_brute_force({}, 0.3)));
}

TEST(Walls, need_little_memory_for_a_huge_extent) {
  const Walls walls({{-1e7, 0, 1e7, 3}, {0, -1e7, 3, 1e7}}, 0.5);
  EXPECT_NEAR(walls.nearest_distance({10.0, 100.0}), 10.0, 3.1);
}

TEST(Walls, rejects_a_non_finite_segment) {
  EXPECT_THROW(Walls({{0, 0, NAN, 1}}), std::invalid_argument);
  EXPECT_THROW(Walls({}, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
