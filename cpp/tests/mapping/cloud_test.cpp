#include "firstlap/mapping/cloud.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "support/mapping_scene.hpp"

namespace firstlap::mapping {
namespace {

using testing::Camera;

TEST(Cloud, normals_of_a_straight_wall_are_perpendicular_and_face_the_lidar) {
  const sim::Walls wall = testing::walls_of({{-20, 2}, {20, 2}, {20, 2.5}, {-20, 2.5}});
  Camera camera(wall);
  CloudMaker maker({}, {});
  ASSERT_TRUE(maker.make(camera.scan({0, 0, 0}), {}));
  int with_normal = 0;
  for (const CloudPoint& p : maker.cloud()) {
    EXPECT_NEAR(p.y, 2.0, 1e-5);
    if (p.nx == 0.0 && p.ny == 0.0) continue;
    ++with_normal;
    EXPECT_NEAR(p.nx, 0.0, 1e-4);
    EXPECT_NEAR(p.ny, -1.0, 1e-4);
  }
  EXPECT_GT(with_normal, 50);
}

TEST(Cloud, points_are_no_closer_to_each_other_than_half_the_spacing) {
  const sim::Walls room = testing::odd_room();
  Camera camera(room);
  CloudMaker maker({}, {});
  ASSERT_TRUE(maker.make(camera.scan({0, 0, 0}), {}));
  const CloudParams params;
  for (std::size_t i = 1; i < maker.cloud().size(); ++i) {
    const CloudPoint &a = maker.cloud()[i - 1], &b = maker.cloud()[i];
    EXPECT_GT(norm(a.x - b.x, a.y - b.y), 0.4 * params.spacing);
  }
  EXPECT_LT(maker.cloud().size(), maker.points().size() / 2);
}

TEST(Cloud, a_corner_has_no_normal) {
  const sim::Walls room = testing::walls_of({{-2, -2}, {2, -2}, {2, 2}, {-2, 2}});
  Camera camera(room);
  CloudMaker maker({}, {});
  ASSERT_TRUE(maker.make(camera.scan({0, 0, 0}), {}));
  for (const CloudPoint& p : maker.cloud()) {
    const bool corner = norm(p.x - 2.0, std::abs(p.y) - 2.0) < 0.04;
    EXPECT_TRUE(!corner || (p.nx == 0.0 && p.ny == 0.0)) << p.x << " " << p.y;
  }
}

TEST(Cloud, a_wall_behind_another_is_a_separate_wall) {
  const sim::Walls room =
      testing::walls_of({{2, -1}, {2, 0.1}, {2.1, 0.1}, {2.1, -1}, {4, -1}, {4, 3}, {-1, 3}, {-1, -1}});
  Camera camera(room);
  CloudMaker maker({}, {});
  ASSERT_TRUE(maker.make(camera.scan({0, 0, 0}), {}));
  for (const CloudPoint& p : maker.cloud()) {
    EXPECT_FALSE(p.x > 2.15 && p.x < 3.95 && p.y > -0.9 && p.y < 2.9) << p.x << " " << p.y;
  }
}

TEST(Cloud, an_invalid_scan_is_refused_and_one_without_returns_gives_an_empty_cloud) {
  CloudMaker maker({}, {});
  const std::vector<float> ranges(100, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(maker.make({0.0, 0.0, 0.0, 0.1, 10.0, ranges}, {}));
  EXPECT_TRUE(maker.make({-1.0, 0.02, 0.0, 0.1, 10.0, ranges}, {}));
  EXPECT_TRUE(maker.cloud().empty());
}

}  // namespace
}  // namespace firstlap::mapping
