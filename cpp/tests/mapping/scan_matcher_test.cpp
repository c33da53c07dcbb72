#include "firstlap/mapping/scan_matcher.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "support/mapping_scene.hpp"

namespace firstlap::mapping {
namespace {

using testing::Camera;

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr Prior free_prior{inf, inf, inf};

TEST(ScanMatcher, finds_a_known_motion_within_a_millimeter_on_exact_scans) {
  const sim::Walls room = testing::odd_room();
  Camera camera(room);
  CloudMaker maker({}, {});
  const ReferenceCloud reference(testing::cloud_of(maker, camera.scan({0, 0, 0})));
  for (const Pose2 truth : {Pose2{0.2, 0.1, 0.1}, Pose2{-0.15, 0.2, -0.15}, Pose2{0.0, -0.25, 0.05}}) {
    const auto cloud = testing::cloud_of(maker, camera.scan(truth));
    const Match found = match(cloud, reference, {}, free_prior, {});
    EXPECT_NEAR(found.pose.x, truth.x, 1e-3);
    EXPECT_NEAR(found.pose.y, truth.y, 1e-3);
    EXPECT_NEAR(found.pose.yaw, truth.yaw, 5e-4);
    EXPECT_GT(found.fit, 0.9);
    EXPECT_LT(found.rms, 5e-3);
  }
}

TEST(ScanMatcher, keeps_odometry_where_the_walls_give_no_information) {
  const sim::Walls corridor = testing::walls_of({{-60, -1}, {60, -1}, {60, 1}, {-60, 1}});
  Camera camera(corridor);
  CloudMaker maker({}, {});
  const ReferenceCloud reference(testing::cloud_of(maker, camera.scan({0, 0, 0})));
  const auto cloud = testing::cloud_of(maker, camera.scan({0.3, 0.05, 0.02}));
  const Match found = match(cloud, reference, {0.25, 0.0, 0.0}, {0.01, 0.05, 0.05}, {});
  EXPECT_NEAR(found.pose.x, 0.25, 5e-3) << "along the corridor, odometry decides";
  EXPECT_NEAR(found.pose.y, 0.05, 2e-3) << "across it, the walls decide";
  EXPECT_NEAR(found.pose.yaw, 0.02, 1e-3);
  EXPECT_GT(found.information[4], 100.0 * found.information[0]) << "and the information matrix shows it";
}

TEST(ScanMatcher, the_other_face_of_a_wall_is_no_correspondence) {
  std::vector<CloudPoint> wall, back;
  for (int i = 0; i < 100; ++i) {
    wall.push_back({0.05 * i, 1.0, 0.0, -1.0});
    back.push_back({0.05 * i, 1.0, 0.0, 1.0});
  }
  const Match found = match(back, ReferenceCloud(wall), {}, free_prior, {});
  EXPECT_EQ(found.fit, 0.0);
}

TEST(ScanMatcher, without_correspondences_the_guess_stays) {
  const Match nothing = match({}, ReferenceCloud({}), {1, 2, 3}, free_prior, {});
  EXPECT_EQ(nothing.pose.x, 1.0);
  EXPECT_EQ(nothing.pose.yaw, 3.0);
  EXPECT_EQ(nothing.fit, 0.0);
  const std::vector<CloudPoint> here{{0, 0, 1, 0}, {0, 1, 1, 0}}, far{{500, 0, 1, 0}, {500, 1, 1, 0}};
  const Match apart = match(here, ReferenceCloud(far), {}, {0.1, 0.1, 0.1}, {});
  EXPECT_EQ(apart.pose.x, 0.0);
  EXPECT_EQ(apart.fit, 0.0);
}

}  // namespace
}  // namespace firstlap::mapping
