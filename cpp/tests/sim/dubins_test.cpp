#include "firstlap/sim/dubins.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "firstlap/common/rng.hpp"

namespace firstlap::sim {
namespace {

TEST(Dubins, every_path_ends_where_it_should_with_pieces_straight_or_at_full_lock) {
  Rng rng(5);
  const double radius = 0.74;
  for (int trial = 0; trial < 2000; ++trial) {
    const Pose2 from{4.0 * rng.uniform(), 4.0 * rng.uniform(), 10.0 * rng.uniform() - 5.0};
    const Pose2 to{4.0 * rng.uniform(), 4.0 * rng.uniform(), 10.0 * rng.uniform() - 5.0};
    const auto paths = dubins_paths(from, to, radius);
    ASSERT_GE(paths.size(), 2U);
    for (const DubinsPath& path : paths) {
      Pose2 at = from;
      for (const Arc& arc : path) {
        ASSERT_GE(arc.length, 0.0);
        ASSERT_TRUE(arc.curvature == 0.0 || std::abs(std::abs(arc.curvature) - 1.0 / radius) < 1e-12);
        at = along(at, arc);
      }
      ASSERT_NEAR(at.x, to.x, 1e-6) << trial;
      ASSERT_NEAR(at.y, to.y, 1e-6) << trial;
      ASSERT_NEAR(std::remainder(at.yaw - to.yaw, 2.0 * std::numbers::pi), 0.0, 1e-6) << trial;
    }
    for (std::size_t i = 1; i < paths.size(); ++i) ASSERT_LE(length(paths[i - 1]), length(paths[i]));
  }
}

TEST(Dubins, known_lengths) {
  const double r = 0.5, pi = std::numbers::pi;
  EXPECT_NEAR(length(dubins_paths({}, {3.0, 0.0, 0.0}, r).front()), 3.0, 1e-9);
  EXPECT_NEAR(length(dubins_paths({}, {0.0, 2.0 * r, pi}, r).front()), pi * r, 1e-9);
  EXPECT_NEAR(length(dubins_paths({}, {2.0 * r, 0.0, pi}, r).front()),
              0.0 + length(dubins_paths({}, {2.0 * r, 0.0, -pi}, r).front()), 1e-9);
  // Turning around on the spot: three arcs of 60, 300 and 60 degrees.
  EXPECT_NEAR(length(dubins_paths({}, {0.0, 0.0, pi}, r).front()), 7.0 / 3.0 * pi * r, 1e-9);
}

TEST(Dubins, an_arc_is_the_sum_of_its_parts) {
  const Pose2 from{1.0, -2.0, 0.3};
  for (const double curvature : {0.0, 1e-9, 1.35, -1.35}) {
    const Pose2 whole = along(from, {curvature, 0.8}), parts = along(along(from, {curvature, 0.3}), {curvature, 0.5});
    EXPECT_NEAR(whole.x, parts.x, 1e-9);
    EXPECT_NEAR(whole.y, parts.y, 1e-9);
    EXPECT_NEAR(whole.yaw, parts.yaw, 1e-12);
  }
}

}  // namespace
}  // namespace firstlap::sim
