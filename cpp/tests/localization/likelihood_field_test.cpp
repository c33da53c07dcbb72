#include "firstlap/localization/likelihood_field.hpp"

#include <gtest/gtest.h>
#include <stdexcept>

#include "support/mapping_scene.hpp"

namespace firstlap::localization {
namespace {

TEST(LikelihoodField, distances_are_those_of_brute_force) {
  constexpr int columns = 37, rows = 23;
  constexpr double resolution = 0.05;
  Rng rng(5);
  std::vector<std::uint8_t> occupied(columns * rows);
  for (auto& cell : occupied) cell = rng.uniform() < 0.02;
  occupied[100] = 1;
  const LikelihoodField field(occupied, columns, rows, resolution, {});
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      double nearest = 1e9;
      for (int i = 0; i < columns * rows; ++i) {
        if (occupied[static_cast<std::size_t>(i)]) {
          nearest = std::min(nearest, norm(i % columns - column, i / columns - row) * resolution);
        }
      }
      const auto center = [&](int i) { return static_cast<float>((i + 0.5) * resolution); };
      EXPECT_NEAR(field.distance_mm(center(column), center(row)), 1000.0 * nearest, 0.6);
    }
  }
}

TEST(LikelihoodField, outside_and_for_nan_the_distance_is_the_maximum) {
  const std::vector<std::uint8_t> one{0, 1, 0, 0};
  const LikelihoodField field(one, 2, 2, 1.0, {});
  EXPECT_EQ(field.distance_mm(1.5F, 0.5F), 0);
  EXPECT_EQ(field.distance_mm(-0.1F, 0.5F), max_distance_mm);
  EXPECT_EQ(field.distance_mm(0.5F, 2.0F), max_distance_mm);
  EXPECT_EQ(field.distance_mm(std::numeric_limits<float>::quiet_NaN(), 0.5F), max_distance_mm);
  EXPECT_EQ(field.slope(100.0, 0.5).dx, 0.0);
}

TEST(LikelihoodField, the_slope_of_a_straight_wall_is_one) {
  std::vector<std::uint8_t> occupied(20 * 20);
  for (std::size_t row = 0; row < 20; ++row) occupied[row * 20 + 4] = 1;
  const LikelihoodField field(occupied, 20, 20, 0.1, {});
  const auto [distance, dx, dy] = field.slope(1.234, 1.0);
  EXPECT_NEAR(distance, 1.234 - 0.45, 1e-3);
  EXPECT_NEAR(dx, 1.0, 1e-9);
  EXPECT_NEAR(dy, 0.0, 1e-9);
}

TEST(LikelihoodField, a_rotated_origin_transforms_poses_there_and_back) {
  const LikelihoodField field(std::vector<std::uint8_t>{1}, 1, 1, 0.05, {3.0, -2.0, 0.7});
  const Pose2 pose{1.0, 5.0, 2.0}, back = field.to_map(field.to_field(pose));
  EXPECT_NEAR(back.x, pose.x, 1e-12);
  EXPECT_NEAR(back.y, pose.y, 1e-12);
  EXPECT_NEAR(back.yaw, pose.yaw, 1e-12);
  EXPECT_NEAR(field.to_field({3.0, -2.0, 0.7}).x, 0.0, 1e-12);
}

TEST(LikelihoodField, a_map_without_walls_is_refused) {
  EXPECT_THROW(LikelihoodField(std::vector<std::uint8_t>(4), 2, 2, 0.05, {}), std::invalid_argument);
  EXPECT_THROW(LikelihoodField(std::vector<std::uint8_t>(3, 1), 2, 2, 0.05, {}), std::invalid_argument);
}

TEST(Search, finds_a_pose_that_is_far_off) {
  const sim::Walls room = testing::odd_room();
  testing::Camera camera(room);
  mapping::CloudMaker maker({}, {});
  const LikelihoodField field = field_of(testing::cloud_of(maker, camera.scan({0, 0, 0})), 0.05);
  std::vector<Beam> beams;
  for (const mapping::CloudPoint& p : testing::cloud_of(maker, camera.scan({0.7, -0.5, 0.3}))) {
    beams.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
  }
  const SearchResult found = search(beams, field, {}, {1.2, 0.5, 0.1, 0.05});
  EXPECT_LT(testing::distance(found.pose, {0.7, -0.5, 0.0}), 0.1);
  EXPECT_NEAR(found.pose.yaw, 0.3, 0.06);
  EXPECT_GT(found.fit, 0.7);
}

}  // namespace
}  // namespace firstlap::localization
