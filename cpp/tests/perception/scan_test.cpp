#include "firstlap/perception/scan.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "support/scene.hpp"

namespace firstlap {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float inf = std::numeric_limits<float>::infinity();

struct Points {
  BeamTable table;
  Buffer<ScanPoint> points{max_points};

  bool from(const LaserScan& scan, const VehicleState& state = {}, const ScanParams& params = {}) {
    points.clear();
    if (!table.prepare(scan)) return false;
    scan_to_points(scan, table, state, params, CarGeometry{}, points);
    return true;
  }
};

scene::Scan constant_scan(std::size_t beams, float range) {
  scene::Scan scan;
  scan.angle_increment = 1.5 * scene::pi / std::max(1.0, static_cast<double>(beams) - 1.0);
  scan.ranges.assign(beams, range);
  return scan;
}

TEST(Scan, puts_a_return_straight_ahead_at_lidar_plus_range) {
  Points p;
  const float ranges[] = {3.0F, inf};
  ASSERT_TRUE(p.from({0.0, 0.01, 0.0, 0.02, 30.0, ranges}));
  ASSERT_EQ(p.points.size(), 1U);
  EXPECT_NEAR(p.points[0].x, CarGeometry{}.laser_x + 3.0, 1e-12);
  EXPECT_NEAR(p.points[0].y, 0.0, 1e-12);
}

TEST(Scan, a_beam_at_plus_90_degrees_is_left) {
  Points p;
  const float ranges[] = {inf, 2.0F};
  ASSERT_TRUE(p.from({0.0, 0.5 * scene::pi, 0.0, 0.02, 30.0, ranges}));
  ASSERT_EQ(p.points.size(), 1U);
  EXPECT_NEAR(p.points[0].y, 2.0, 1e-9);
}

TEST(Scan, no_encoding_of_no_return_becomes_a_point) {
  Points p;
  const float ranges[] = {nan, inf, -inf, 0.0F, -1.0F, 65.533F, 31.0F, 0.01F, 12.0F, 3.0F};
  ASSERT_TRUE(p.from({-0.05, 0.01, 0.0, 0.02, 30.0, ranges}));
  ASSERT_EQ(p.points.size(), 1U) << "only 3 m is a return; 12 m is range_use";
  EXPECT_EQ(p.points[0].beam, 9);
  const float clipped[] = {8.0F, 7.98F, 8.02F, 7.96F, 7.94F};
  ASSERT_TRUE(p.from({-0.05, 0.01, 0.0, 0.02, 8.0, clipped}));
  ASSERT_EQ(p.points.size(), 1U) << "a range clipped at range_max, plus noise, is not a wall";
  EXPECT_EQ(p.points[0].beam, 4);
}

TEST(Scan, points_farther_than_2_m_behind_the_front_axle_are_dropped) {
  Points p;
  ASSERT_TRUE(p.from(constant_scan(1081, 4.0F).view()));
  const double limit = CarGeometry{}.wheelbase - 2.0;
  double rearmost = 0.0;
  for (const ScanPoint& q : p.points) rearmost = std::min(rearmost, q.x);
  EXPECT_GE(rearmost, limit);
  EXPECT_LT(rearmost, limit + 0.05) << "points before the limit are kept";
}

TEST(Scan, the_car_does_not_see_its_own_body) {
  Points p;
  ASSERT_TRUE(p.from(constant_scan(1081, 0.12F).view()));
  for (const ScanPoint& q : p.points)
    EXPECT_FALSE(q.x > -0.125 && q.x < 0.455 && std::abs(q.y) < 0.155) << q.x << ' ' << q.y;
  // Spurious returns at 118 to 135 degrees, closer than mask_range.
  std::vector<float> streak(45, inf);
  for (std::size_t i = 42; i < 45; ++i) streak[i] = 0.25F;
  ASSERT_TRUE(p.from({0.0, 0.05, 0.0, 0.02, 30.0, streak}));
  EXPECT_EQ(p.points.size(), 0U);
}

TEST(Scan, clockwise_beams_give_the_same_points) {
  const scene::Scan scan = scene::Course{}.straight(20).walls(2.0).scan({5.0, 0.2, 0.1});
  scene::Scan clockwise = scan;
  clockwise.angle_min = -scan.angle_min;
  clockwise.angle_increment = -scan.angle_increment;
  std::reverse(clockwise.ranges.begin(), clockwise.ranges.end());
  Points a;
  Points b;
  ASSERT_TRUE(a.from(scan.view()));
  ASSERT_TRUE(b.from(clockwise.view()));
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_NEAR(a.points[i].x, b.points[i].x, 1e-9);
    EXPECT_NEAR(a.points[i].y, b.points[i].y, 1e-9);
    EXPECT_EQ(a.points[i].beam, b.points[i].beam);
  }
}

// The same full turn of beams, starting at another one, in either direction.
scene::Scan stored_from(const scene::Scan& scan, std::size_t first, bool clockwise) {
  scene::Scan other = scan;
  const std::size_t n = scan.ranges.size();
  for (std::size_t i = 0; i < n; ++i) other.ranges[i] = scan.ranges[(first + (clockwise ? n - i : i)) % n];
  other.angle_min = scan.angle_min + scan.angle_increment * static_cast<double>(first);
  if (clockwise) other.angle_increment = -scan.angle_increment;
  return other;
}

scene::Scan full_turn(std::size_t beams) {
  scene::Scan scan;
  scan.angle_min = -scene::pi;
  scan.angle_increment = 2.0 * scene::pi / static_cast<double>(beams);
  scan.ranges.resize(beams);
  for (std::size_t i = 0; i < beams; ++i) scan.ranges[i] = 4.0F + 0.001F * static_cast<float>(i);
  return scan;
}

TEST(Scan, the_position_of_the_seam_does_not_matter) {
  const scene::Scan scan = full_turn(720);
  Points a;
  ASSERT_TRUE(a.from(scan.view()));
  ASSERT_EQ(a.table.size(), 720U);
  for (const std::size_t first : {0U, 1U, 180U, 359U, 360U, 361U, 719U}) {
    for (const bool clockwise : {false, true}) {
      for (const double turns : {-2.0 * scene::pi, 0.0, 2.0 * scene::pi}) {
        scene::Scan other = stored_from(scan, first, clockwise);
        other.angle_min += turns;
        Points b;
        ASSERT_TRUE(b.from(other.view()));
        ASSERT_EQ(a.points.size(), b.points.size()) << first << clockwise;
        for (std::size_t i = 0; i < a.points.size(); ++i) {
          ASSERT_NEAR(a.points[i].x, b.points[i].x, 1e-9) << first << clockwise;
          ASSERT_NEAR(a.points[i].y, b.points[i].y, 1e-9) << first << clockwise;
          ASSERT_NEAR(a.points[i].beam, b.points[i].beam, 1) << first << clockwise;
        }
      }
    }
  }
}

TEST(Scan, beams_that_cross_straight_behind_leave_empty_slots_where_no_beam_points) {
  scene::Scan scan;  // three quarters of a turn, blind on the right
  scan.angle_min = -0.25 * scene::pi;
  scan.angle_increment = 1.5 * scene::pi / 540.0;
  scan.ranges.assign(541, 2.0F);
  BeamTable table;
  ASSERT_TRUE(table.prepare(scan.view()));
  EXPECT_EQ(table.size(), 720U);
  std::size_t empty = 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    empty += table.source(i) == BeamTable::no_source ? 1 : 0;
    EXPECT_NEAR(std::remainder(std::atan2(table.sine(i), table.cosine(i)) - table.angle(i), 2.0 * scene::pi), 0.0,
                1e-9);
    EXPECT_TRUE(i == 0 || table.angle(i) > table.angle(i - 1));
  }
  EXPECT_EQ(empty, 720U - 541U);
}

TEST(Scan, a_full_turn_whose_last_beams_repeat_the_first_uses_each_direction_once) {
  scene::Scan scan = full_turn(360);
  scan.angle_min = 0.0;
  scan.ranges.push_back(1.0F);
  scan.ranges.push_back(1.001F);
  BeamTable table;
  ASSERT_TRUE(table.prepare(scan.view()));
  EXPECT_EQ(table.size(), 360U);
}

TEST(Scan, dense_scans_that_cross_straight_behind_are_thinned_to_the_table) {
  scene::Scan scan = full_turn(10000);
  scan.angle_min = 0.0;
  BeamTable table;
  ASSERT_TRUE(table.prepare(scan.view()));
  EXPECT_LE(table.size(), max_points);
  EXPECT_GE(table.size(), max_points / 2);
  scan.ranges.resize(7);  // barely more than straight behind, with the smallest increment
  scan.angle_min = scene::pi - 2e-9;
  scan.angle_increment = 1e-9;
  EXPECT_FALSE(table.prepare(scan.view())) << "nothing ahead";
}

TEST(Scan, the_lidar_may_be_mounted_off_center) {
  CarGeometry car;
  car.laser_y = 0.08;
  const float ranges[] = {3.0F, inf};
  BeamTable table;
  Buffer<ScanPoint> points{max_points};
  const LaserScan scan{0.0, 0.01, 0.0, 0.02, 30.0, ranges};
  ASSERT_TRUE(table.prepare(scan));
  scan_to_points(scan, table, {}, {}, car, points);
  ASSERT_EQ(points.size(), 1U);
  EXPECT_NEAR(points[0].y, 0.08, 1e-12);
}

TEST(Scan, a_dense_scan_is_thinned_evenly_over_its_whole_field_of_view) {
  Points p;
  ASSERT_TRUE(p.from(constant_scan(10000, 1.0F).view()));
  EXPECT_LE(p.table.size(), max_points);
  EXPECT_GE(p.table.size(), max_points / 2);
  EXPECT_NEAR(p.table.angle_first(), -0.75 * scene::pi, 1e-9);
  EXPECT_NEAR(p.table.angle_first() + p.table.angle_step() * static_cast<double>(p.table.size() - 1), 0.75 * scene::pi,
              0.01);
}

// A wall ahead, approached at v: a beam measured t before the end of the sweep is longer by v t.
TEST(Scan, the_motion_during_the_sweep_is_undone) {
  constexpr double v = 8.0;
  constexpr double omega = 2.0;
  constexpr double beam_time = 18.75e-3 / 1080.0;
  const double wall_x = 5.0;  // in base_link at the end of the sweep
  scene::Scan scan = constant_scan(1081, 0.0F);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double t = static_cast<double>(scan.ranges.size() - 1 - i) * beam_time;
    const double yaw = -omega * t;
    // Exact arc: the pose of base_link t before the end.
    const double x = -v / omega * std::sin(omega * t);
    const double laser_x = x + CarGeometry{}.laser_x * std::cos(yaw);
    const double angle = yaw + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    if (std::cos(angle) > 0.5) scan.ranges[i] = static_cast<float>((wall_x - laser_x) / std::cos(angle));
  }
  LaserScan view = scan.view();
  view.time_increment = beam_time;
  Points p;
  ASSERT_TRUE(p.from(view, {v, omega, 0.0}));
  ASSERT_GT(p.points.size(), 300U);
  for (const ScanPoint& q : p.points) EXPECT_NEAR(q.x, wall_x, 0.005);

  ScanParams off;
  off.deskew = false;
  ASSERT_TRUE(p.from(view, {v, omega, 0.0}, off));
  double worst = 0.0;
  for (const ScanPoint& q : p.points) worst = std::max(worst, std::abs(q.x - wall_x));
  EXPECT_GT(worst, 0.05) << "without deskewing the wall is distorted";
}

TEST(Scan, an_invalid_header_is_refused) {
  const std::vector<float> ranges(100, 1.0F);
  BeamTable table;
  const double nan_d = std::numeric_limits<double>::quiet_NaN();
  const double inf_d = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(table.prepare({-1.0, 0.01, 0.0, 0.02, inf_d, ranges})) << "an infinite limit is valid";
  EXPECT_FALSE(table.prepare({-1.0, 0.01, 0.0, 0.02, 30.0, {}})) << "no beams";
  EXPECT_FALSE(table.prepare({-1.0, 0.0, 0.0, 0.02, 30.0, ranges})) << "zero increment";
  EXPECT_FALSE(table.prepare({nan_d, 0.01, 0.0, 0.02, 30.0, ranges}));
  EXPECT_FALSE(table.prepare({-1.0, nan_d, 0.0, 0.02, 30.0, ranges}));
  EXPECT_FALSE(table.prepare({-1.0, 1.0, 0.0, 0.02, 30.0, ranges})) << "many turns";
  EXPECT_FALSE(table.prepare({-1.0, 0.01, 0.0, 30.0, 0.02, ranges})) << "limits swapped";
  EXPECT_FALSE(table.prepare({-1.0, 0.01, 0.0, nan_d, 30.0, ranges}));
  EXPECT_FALSE(table.prepare({-1.0, 0.01, nan_d, 0.02, 30.0, ranges}));
  EXPECT_FALSE(table.prepare({-1.0, 0.01, -1.0, 0.02, 30.0, ranges}));
}

TEST(Scan, the_table_follows_a_change_of_the_scan_header) {
  BeamTable table;
  const std::vector<float> many(200, 1.0F);
  const std::vector<float> few(100, 1.0F);
  ASSERT_TRUE(table.prepare({-1.0, 0.01, 0.0, 0.02, 30.0, many}));
  ASSERT_TRUE(table.prepare({-0.5, 0.01, 0.0, 0.02, 30.0, few}));
  EXPECT_EQ(table.size(), 100U);
  EXPECT_NEAR(table.cosine(0), std::cos(-0.5), 1e-12);
  ASSERT_TRUE(table.prepare({0.5, -0.01, 0.0, 0.02, 30.0, few}));
  EXPECT_NEAR(table.angle_first(), 0.5 - 0.99, 1e-12);
}

}  // namespace
}  // namespace firstlap
