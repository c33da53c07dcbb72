#include "firstlap/drivers/sweep.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap::drivers {
namespace {

constexpr float lost = INFINITY;

scene::Scan around(std::vector<float> ranges) {
  scene::Scan scan{.angle_min = -1.0, .range_min = 0.05, .ranges = std::move(ranges)};
  scan.angle_increment = 2.0 / static_cast<double>(scan.ranges.size() - 1);
  return scan;
}

TEST(Sweep, a_few_lost_beams_take_the_range_of_the_nearer_neighbor) {
  Sweep sweep;
  ASSERT_TRUE(sweep.read(around({3, 3, lost, NAN, 2, 2, 2}).view(), {}, {}, {.max_lost_beams = 10}, {}));
  EXPECT_EQ(sweep.range(2), 2.0);
  EXPECT_EQ(sweep.range(3), 2.0);
  EXPECT_EQ(sweep.points().size(), 5U);
}

TEST(Sweep, many_lost_beams_take_the_lost_range) {
  std::vector<float> ranges(100, 5.0F);
  std::fill(ranges.begin() + 30, ranges.begin() + 60, lost);
  Sweep sweep;
  ASSERT_TRUE(sweep.read(around(ranges).view(), {}, {}, {.lost_range = 1.5}, {}));
  for (std::size_t i = 30; i < 60; ++i) EXPECT_EQ(sweep.range(i), 1.5);
  EXPECT_EQ(sweep.range(29), 5.0);
}

TEST(Sweep, ranges_are_clipped_and_give_no_point_beyond_the_limit) {
  Sweep sweep;
  ASSERT_TRUE(sweep.read(around({3, 20, 29, 4, 5, 6}).view(), {}, {}, {.range_use = 8.0}, {}));
  EXPECT_EQ(sweep.range(1), 8.0);
  EXPECT_EQ(sweep.range(2), 8.0);
  EXPECT_EQ(sweep.points().size(), 4U);
}

TEST(Sweep, returns_from_the_cars_own_body_are_lost) {
  Sweep sweep;
  ASSERT_TRUE(sweep.read(around({3, 3, 0.1F, 3, 3}).view(), {}, {}, {}, {}));
  EXPECT_EQ(sweep.range(2), 3.0);
}

TEST(Sweep, clockwise_scans_are_read_right_to_left) {
  const scene::Scan scan = around({1, 2, 3, 4, 5});
  scene::Scan clockwise = scan;
  clockwise.angle_min = 1.0;
  clockwise.angle_increment = -scan.angle_increment;
  Sweep sweep;
  ASSERT_TRUE(sweep.read(clockwise.view(), {}, {}, {}, {}));
  EXPECT_NEAR(sweep.angle(0), -1.0, 1e-12);
  EXPECT_EQ(sweep.range(0), 5.0);
  EXPECT_EQ(sweep.beam_at(1.0), 4U);
  EXPECT_EQ(sweep.beam_at(9.0), 4U);
}

}  // namespace
}  // namespace firstlap::drivers
