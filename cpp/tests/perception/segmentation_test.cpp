#include "firstlap/perception/segmentation.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "support/scene.hpp"

namespace firstlap {
namespace {

struct Segmented {
  explicit Segmented(const scene::Scan& scan, double width = 2.0, const SegmentationParams& params = {}) {
    BeamTable table;
    if (!table.prepare(scan.view())) return;
    scan_to_points(scan.view(), table, {}, {}, CarGeometry{}, points);
    segment(points, table.angle_step(), width, params, sections);
  }
  [[nodiscard]] std::size_t count(SectionStatus status) const {
    std::size_t n = 0;
    for (const Section& s : sections) n += s.status == status;
    return n;
  }
  Buffer<ScanPoint> points{max_points};
  Buffer<Section> sections{max_sections};
};

// Range as a function of the angle in the LiDAR's frame; infinite without a wall.
scene::Scan scan_of(const std::function<double(double)>& range) {
  scene::Scan scan;
  for (int i = 0; i <= 1080; ++i)
    scan.ranges.push_back(static_cast<float>(range(scan.angle_min + i * scan.angle_increment)));
  return scan;
}
constexpr double nothing = std::numeric_limits<double>::infinity();

TEST(Segmentation, sections_cover_every_point_once_and_in_order) {
  const Segmented s(scene::Course{}.straight(4).turn(1.5, 2.0).straight(6).pipes(2.0, 0.7, 0.3).scan({2.0, 0.0, 0.0}));
  ASSERT_GT(s.sections.size(), 2U);
  EXPECT_EQ(s.sections.front().first, 0U);
  for (std::size_t i = 1; i < s.sections.size(); ++i) EXPECT_EQ(s.sections[i].first, s.sections[i - 1].last + 1);
  EXPECT_EQ(s.sections.back().last, s.points.size() - 1);
}

TEST(Segmentation, a_straight_corridor_is_two_sections) {
  const Segmented s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0}));
  EXPECT_EQ(s.count(SectionStatus::kept), 2U);
}

TEST(Segmentation, a_wall_met_at_grazing_incidence_stays_one_section_to_10_m) {
  // 1 m beside the car, beams 0.25 degrees apart: 0.44 m between points at 10 m.
  scene::Scene wall;
  wall.add(scene::left, {{0.0, 1.0}, {30.0, 1.0}});
  const Segmented s(wall.scan({2.0, 0.0, 0.0}));
  ASSERT_EQ(s.count(SectionStatus::kept), 1U);
  const Section& only = s.sections[s.sections.size() - 1];
  EXPECT_GT(s.points[only.first].range, 10.0) << "it must reach that far";
}

TEST(Segmentation, a_jump_above_the_largest_threshold_is_a_break) {
  const Segmented s(scan_of([](double angle) { return angle < 0.0 ? 2.0 : 3.0; }));
  EXPECT_EQ(s.sections.size(), 2U);
}

TEST(Segmentation, a_jump_below_the_smallest_threshold_is_no_break) {
  const Segmented s(scan_of([](double angle) { return angle < 0.0 ? 2.0 : 2.1; }));
  EXPECT_EQ(s.sections.size(), 1U);
}

// A wall half a meter beside the car has an angle of incidence of 0.07 rad at 7 m: below break_angle, so that only the
// weighted mean of the previous distances shows that it continues.
TEST(Segmentation, the_weighted_mean_of_previous_distances_keeps_a_wall_at_grazing_incidence_in_one_section) {
  scene::Scene wall;
  wall.add(scene::right, {{0.0, -0.5}, {7.5, -0.5}});
  const scene::Scan scan = wall.scan({0.0, 0.0, 0.0});
  EXPECT_EQ(Segmented(scan).sections.size(), 1U);
  EXPECT_GT(Segmented(scan).points.back().range, 7.0);
  SegmentationParams one_mean;
  one_mean.mean_factor = 1.0;
  EXPECT_GT(Segmented(scan, 2.0, one_mean).sections.size(), 1U) << "the threshold is a multiple of the mean";
  SegmentationParams slow;
  slow.mean_gain = 0.01;
  EXPECT_GT(Segmented(scan, 2.0, slow).sections.size(), 1U) << "a slow mean lags behind";
}

TEST(Segmentation, a_distance_above_break_max_is_a_break_regardless_of_the_mean) {
  scene::Scene wall;
  wall.add(scene::right, {{0.0, -0.5}, {9.5, -0.5}});
  const SegmentationParams params;
  const Segmented s(wall.scan({0.0, 0.0, 0.0}));
  ASSERT_GT(s.sections.size(), 1U);
  const auto step = [&](std::size_t i) {
    return std::hypot(s.points[i + 1].x - s.points[i].x, s.points[i + 1].y - s.points[i].y);
  };
  const Section& near = s.sections[0];
  for (std::size_t i = near.first; i < near.last; ++i) EXPECT_LE(step(i), params.break_max);
  EXPECT_GT(step(near.last), params.break_max);
  EXPECT_LT(step(near.last), passable_gap(2.0, params)) << "not passable yet";
}

TEST(Segmentation, more_consecutive_lost_beams_than_max_beam_gap_are_a_break) {
  SegmentationParams params;
  params.merge_distance = 0.0;
  for (const int lost : {params.max_beam_gap - 1, params.max_beam_gap}) {
    scene::Scan scan = scan_of([](double angle) { return std::abs(angle) < 0.2 ? 7.0 : nothing; });
    for (int i = 0; i < lost; ++i) scan.ranges[static_cast<std::size_t>(540 + i)] = 0.0F;
    EXPECT_EQ(Segmented(scan, 2.0, params).sections.size(), lost < params.max_beam_gap ? 1U : 2U) << lost;
  }
}

TEST(Segmentation, neighbors_closer_than_the_merge_distance_are_merged) {
  EXPECT_EQ(Segmented(scan_of([](double angle) { return angle < 0.0 ? 2.0 : 2.33; })).sections.size(), 1U);
  EXPECT_EQ(Segmented(scan_of([](double angle) { return angle < 0.0 ? 2.0 : 2.37; })).sections.size(), 2U);
}

TEST(Segmentation, sections_with_few_points_a_short_chord_or_far_away_are_eliminated) {
  // A post of 5 beams ahead of a wall that is 6 m away.
  const auto post = [](double half, double at) {
    return scan_of([=](double angle) { return std::abs(angle) < half ? at : nothing; });
  };
  EXPECT_EQ(Segmented(post(2.2 * 0.00436, 3.0)).count(SectionStatus::too_small), 1U) << "5 points";
  EXPECT_EQ(Segmented(post(0.03, 3.0)).count(SectionStatus::too_small), 1U) << "a chord of 0.18 m";
  EXPECT_EQ(Segmented(post(0.06, 3.0)).count(SectionStatus::kept), 1U) << "a chord of 0.36 m";
  EXPECT_EQ(Segmented(post(0.06, 8.5)).count(SectionStatus::too_far), 1U);
}

// A wall of 2 m, 3 m ahead of the LiDAR, turned by `angle` from the car's heading.
TEST(Segmentation, a_section_across_the_heading_is_eliminated_by_its_angle) {
  SegmentationParams params;
  params.max_angle = 1.2;
  for (const double angle : {-1.5, -1.3, -1.1, -0.6, 0.6, 1.1, 1.3, 1.5}) {
    const double dx = std::cos(angle);
    const double dy = std::sin(angle);
    scene::Scene wall;
    wall.add(scene::neither, {{3.27 - dx, 0.5 - dy}, {3.27 + dx, 0.5 + dy}});
    const scene::Scan scan = wall.scan({0.0, 0.0, 0.0});
    const Segmented s(scan, 2.0, params);
    ASSERT_EQ(s.sections.size(), 1U) << angle;
    EXPECT_NEAR(s.sections[0].angle, std::abs(angle), 0.02) << angle;
    EXPECT_EQ(s.sections[0].status, std::abs(angle) > 1.2 ? SectionStatus::across : SectionStatus::kept) << angle;
    EXPECT_EQ(Segmented(scan).sections[0].status, SectionStatus::kept) << "off by default, at " << angle;
  }
}

// Beams 1 degree apart: a wall across at 6 m has a point every 0.1 m, so that its chord is long enough.
TEST(Segmentation, a_section_with_too_few_points_is_eliminated_regardless_of_its_chord) {
  const auto wall_of = [](int beams) {
    scene::Scan scan;
    scan.angle_increment *= 4.0;
    scan.ranges.assign(271, std::numeric_limits<float>::infinity());
    for (int i = 0; i < beams; ++i) scan.ranges[static_cast<std::size_t>(133 + i)] = 6.0F;
    return scan;
  };
  const SegmentationParams params;
  const Segmented few(wall_of(params.min_points - 1));
  ASSERT_EQ(few.sections.size(), 1U);
  ASSERT_GT(few.sections[0].length, params.min_chord);
  EXPECT_EQ(few.sections[0].status, SectionStatus::too_small);
  EXPECT_EQ(Segmented(wall_of(params.min_points)).sections[0].status, SectionStatus::kept);
}

TEST(Segmentation, sections_visible_through_a_joint_are_dropped_and_both_neighbors_kept) {
  scene::Scene pipes;
  pipes.add(scene::left, {{0.0, 1.0}, {3.0, 1.0}}).add(scene::left, {{3.5, 1.0}, {7.0, 1.0}});
  pipes.add(scene::neither, {{0.0, 3.0}, {12.0, 3.0}});
  const Segmented s(pipes.scan({2.0, 0.0, 0.0}));
  EXPECT_GE(s.count(SectionStatus::seen_through), 1U);
  for (const Section& section : s.sections) {
    const double y = s.points[(section.first + section.last) / 2].y;
    if (section.status == SectionStatus::kept && s.points[section.last].x > 2.5 && s.points[section.first].x < 6.0) {
      EXPECT_NEAR(y, 1.0, 0.01);
    }
  }
}

TEST(Segmentation, a_section_in_front_of_a_joint_is_not_dropped) {
  scene::Scene pipes;
  pipes.add(scene::left, {{0.0, 3.0}, {5.0, 3.0}}).add(scene::left, {{5.8, 3.0}, {10.0, 3.0}});
  pipes.add(scene::neither,
            {{3.68, 1.5}, {3.97, 1.5}});  // halfway to the joint, too far from it to be part of the wall
  const Segmented s(pipes.scan({2.0, 0.0, 0.0}));
  EXPECT_EQ(s.count(SectionStatus::seen_through), 0U);
  EXPECT_EQ(s.count(SectionStatus::kept), 3U);
}

TEST(Segmentation, sections_visible_through_a_passable_gap_are_kept) {
  scene::Scene opening;
  opening.add(scene::left, {{0.0, 1.0}, {2.5, 1.0}}).add(scene::left, {{4.5, 1.0}, {7.0, 1.0}});
  opening.add(scene::neither, {{2.0, 3.0}, {8.0, 3.0}});
  EXPECT_EQ(Segmented(opening.scan({2.0, 0.0, 0.0})).count(SectionStatus::seen_through), 0U);
}

TEST(Segmentation, the_passable_gap_is_a_share_of_the_track_width_within_limits) {
  const SegmentationParams p;
  EXPECT_DOUBLE_EQ(passable_gap(2.0, p), 0.9);
  EXPECT_DOUBLE_EQ(passable_gap(0.7, p), 0.5);
  EXPECT_DOUBLE_EQ(passable_gap(3.5, p), 1.0);
}

TEST(Segmentation, thinned_beams_still_give_two_walls_in_a_corridor) {
  for (const int keep_every : {2, 3, 4}) {
    scene::Scan scan = scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0});
    for (std::size_t i = 0; i < scan.ranges.size(); ++i)
      if (i % static_cast<std::size_t>(keep_every) != 0) scan.ranges[i] = 0.0F;
    EXPECT_EQ(Segmented(scan).count(SectionStatus::kept), 2U) << "one beam of " << keep_every;
  }
}

TEST(Segmentation, the_median_beam_step_is_the_spacing_of_the_returns) {
  Buffer<ScanPoint> points(max_points);
  EXPECT_DOUBLE_EQ(median_beam_step(points), 1.0);
  for (int i = 0; i < 100; ++i) points.push({1.0, 0.0, 1.0, 3 * i});
  EXPECT_DOUBLE_EQ(median_beam_step(points), 3.0);
}

TEST(Segmentation, sections_beyond_the_capacity_are_dropped) {
  int k = 0;
  scene::Scan scan = scan_of([&](double) { return ++k % 2 == 0 ? 2.0 : 7.0; });
  const Segmented s(scan);
  EXPECT_LE(s.sections.size(), max_sections);
}

}  // namespace
}  // namespace firstlap
