#include "firstlap/perception/sides.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "support/scene.hpp"

namespace firstlap {
namespace {

// A first scan: everything up to the split, without previous sides.
struct Sides {
  explicit Sides(const scene::Scan& scan) {
    BeamTable table;
    if (!table.prepare(scan.view())) return;
    scan_to_points(scan.view(), table, {}, {}, CarGeometry{}, points);
    segment(points, table.angle_step(), width, params, sections);
    sample_sections(points, sections, CarGeometry{}, spacing, params, samples);
  }
  void choose() {
    candidates = rank_splits({points, sections, samples}, width, params);
    if (candidates.count > 0)
      split_into_sides({points, sections, samples}, {candidates.items[0].split, width, spacing}, CarGeometry{}, params,
                       walls);
  }
  SegmentationParams params{};
  double width = 2.0;
  double spacing = 0.15;
  Buffer<ScanPoint> points{max_points};
  Buffer<Section> sections{max_sections};
  Buffer<SectionSample> samples{2 * max_samples};
  Candidates candidates;
  LocalWalls walls;
};

TEST(Sides, in_a_corridor_negative_y_is_right_and_positive_y_is_left) {
  Sides s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.3, 0.2}));
  s.choose();
  const Pose2 car{10.0, 0.3, 0.2};
  ASSERT_GT(s.walls.right.size(), 20U);
  ASSERT_GT(s.walls.left.size(), 20U);
  for (std::size_t i = 0; i < s.walls.right.size(); ++i)
    EXPECT_NEAR(scene::to_world(car, s.walls.right.x[i], s.walls.right.y[i]).y, -1.0, 0.01);
  for (std::size_t i = 0; i < s.walls.left.size(); ++i)
    EXPECT_NEAR(scene::to_world(car, s.walls.left.x[i], s.walls.left.y[i]).y, 1.0, 0.01);
}

TEST(Sides, samples_are_about_a_spacing_apart_and_on_the_wall) {
  const Sides s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0}));
  for (std::size_t i = 0; i < s.samples.size(); ++i) {
    EXPECT_NEAR(std::abs(s.samples[i].y), 1.0, 1e-3);
    if (i == 0 || s.samples[i].section != s.samples[i - 1].section) continue;
    const double d = std::hypot(s.samples[i].x - s.samples[i - 1].x, s.samples[i].y - s.samples[i - 1].y);
    EXPECT_LT(d, 2.0 * s.spacing);
  }
}

TEST(Sides, a_single_wall_on_the_left_is_left_and_on_the_right_is_right) {
  for (const int side : {scene::left, scene::right}) {
    scene::Scene wall;
    wall.add(side, {{-5.0, 1.0 * side}, {20.0, 1.0 * side}});
    Sides s(wall.scan({0.0, 0.0, 0.0}));
    s.choose();
    EXPECT_EQ(s.walls.left.size() > 0, side == scene::left);
    EXPECT_EQ(s.walls.right.size() > 0, side == scene::right);
  }
}

TEST(Sides, a_candidate_that_contradicts_previous_sides_scores_less) {
  Sides s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0}));
  s.choose();
  const double without_past = s.candidates.items[0].score;
  const std::size_t split = s.candidates.items[0].split;
  for (SectionSample& sample : s.samples) sample.vote = sample.section < split ? -1 : 1;
  s.choose();
  EXPECT_EQ(s.candidates.items[0].split, split);
  EXPECT_NEAR(s.candidates.items[0].score, without_past, 1e-9) << "full agreement has no penalty";
  for (SectionSample& sample : s.samples) sample.vote = -sample.vote;
  s.choose();
  for (std::size_t i = 0; i < s.candidates.count; ++i) {
    if (s.candidates.items[i].split == split) {
      EXPECT_LT(s.candidates.items[i].score, 0.2 * without_past);
    }
  }
}

TEST(Sides, a_wall_keeps_its_side_when_it_is_the_only_one_and_surrounds_the_car) {
  // The right wall of a left-hand hairpin: from the right, around the front, to the left.
  scene::Scene wall;
  wall.add(scene::right, scene::Course{}.turn(2.0, scene::pi).straight(3.0).parallel(-1.0, 0.0, 9.0));
  Sides s(wall.scan({0.0, 0.0, 0.0}));
  for (SectionSample& sample : s.samples) sample.vote = -1;
  s.choose();
  EXPECT_EQ(s.walls.left.size(), 0U);
  EXPECT_GT(s.walls.right.size(), 20U);
}

TEST(Sides, votes_come_from_earlier_walls_at_the_same_place) {
  Sides s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0}));
  LocalWalls before;
  for (double x = -1.0; x < 5.0; x += 0.15) {
    before.left.push(x, -1.0, {}, 0.0F);  // sides swapped
    before.right.push(x, 1.0, {}, 0.0F);
  }
  label_from_history(before, Buffer<TrajectoryPoint>(8), Buffer<TrailPoint>(8), s.params, s.samples);
  for (const SectionSample& sample : s.samples) {
    if (sample.x > -0.5 && sample.x < 4.5) {
      EXPECT_EQ(sample.vote, sample.y < 0.0 ? 1 : -1);
    }
  }
}

TEST(Sides, votes_come_from_the_previous_path_where_there_was_no_wall) {
  Sides s(scene::Course{}.straight(40).walls(2.0).scan({10.0, 0.0, 0.0}));
  Buffer<TrajectoryPoint> path(100);
  for (int i = 0; i < 60; ++i) path.push({0.1 * i, 0.1 * i - 1.0, 0.0, 0.0, 0.0, 1.0});
  label_from_history(LocalWalls{}, path, Buffer<TrailPoint>(8), s.params, s.samples);
  for (const SectionSample& sample : s.samples) {
    if (sample.x > -0.5 && sample.x < 4.0) {
      EXPECT_EQ(sample.vote, sample.y > 0.0 ? 1 : -1);
    }
    if (sample.x > 7.0) {
      EXPECT_EQ(sample.vote, 0) << "too far to tell";
    }
  }
}

// Three kept sections of two points each, right to left, with two gaps between them.
struct TwoGaps {
  struct Gap {
    Point2 from;
    Point2 to;
  };

  TwoGaps(Gap first, Gap second) {
    add({1.0, -1.0}, first.from);
    add(first.to, second.from);
    add(second.to, {1.0, 1.0});
  }
  // Score of the gap before a section; 0 if it is no candidate.
  [[nodiscard]] double score(std::size_t split, double width) const {
    const Buffer<SectionSample> no_past(1);
    const Candidates found = rank_splits({points, sections, no_past}, width, {});
    for (std::size_t i = 0; i < found.count; ++i)
      if (found.items[i].split == split) return found.items[i].score;
    return 0.0;
  }
  [[nodiscard]] static double depth(const Gap& gap) { return std::max(range(gap.from), range(gap.to)); }

 private:
  static double range(Point2 p) { return std::hypot(p.x - car.laser_x, p.y); }
  void add(Point2 from, Point2 to) {
    sections.push({.first = points.size(), .last = points.size() + 1});
    for (const Point2 p : {from, to}) points.push({p.x, p.y, range(p), static_cast<int>(points.size())});
  }

  static constexpr CarGeometry car{};
  Buffer<ScanPoint> points{8};
  Buffer<Section> sections{8};
};

TEST(Sides, a_gap_narrower_than_the_track_scores_by_its_share_of_the_width) {
  const TwoGaps::Gap deep{{6.0, -2.0}, {6.0, -1.0}};  // 1 m wide
  const TwoGaps::Gap wide{{5.0, 0.0}, {5.0, 1.6}};
  const TwoGaps gaps(deep, wide);
  constexpr double width = 2.0;
  EXPECT_NEAR(gaps.score(2, width), TwoGaps::depth(wide), 1e-9) << "a gap of 0.8 track widths has the full score";
  EXPECT_NEAR(gaps.score(1, width), TwoGaps::depth(deep) * 1.0 / (0.7 * width), 1e-9);
  EXPECT_GT(gaps.score(2, width), gaps.score(1, width)) << "the deeper gap is too narrow for this track";
  EXPECT_GT(gaps.score(1, 1.0), gaps.score(2, 1.0)) << "on a narrower track it is where the track continues";
}

TEST(Sides, a_gap_in_line_with_the_walls_on_both_sides_is_a_hole_with_a_fifth_of_the_score) {
  const TwoGaps::Gap in_line{{5.0, -1.0}, {6.5, -1.0}};
  const TwoGaps::Gap around{{9.0, -1.0}, {9.0, 1.0}};
  const TwoGaps gaps(in_line, around);
  EXPECT_NEAR(gaps.score(1, 2.0), 0.2 * TwoGaps::depth(in_line), 1e-9);
  EXPECT_NEAR(gaps.score(2, 2.0), TwoGaps::depth(around), 1e-9);
}

TEST(Sides, candidates_are_ranked_best_first) {
  Sides s(scene::Course{}
              .straight(6)
              .turn(1.5, 1.5)
              .straight(3)
              .turn(1.5, -1.5)
              .straight(5)
              .pipes(2.0, 0.8, 0.5)
              .scan({2.0, 0.0, 0.0}));
  s.choose();
  ASSERT_GE(s.candidates.count, 1U);
  for (std::size_t i = 1; i < s.candidates.count; ++i)
    EXPECT_GE(s.candidates.items[i - 1].score, s.candidates.items[i].score);
}

TEST(Sides, a_narrow_joint_is_bridged_and_a_wide_one_is_open) {
  for (const double joint : {0.5, 1.5}) {
    scene::Scene scene;
    scene.add(scene::right, {{-5.0, -1.0}, {20.0, -1.0}});
    scene.add(scene::left, {{-5.0, 1.0}, {2.0, 1.0}}).add(scene::left, {{2.0 + joint, 1.0}, {8.0, 1.0}});
    Sides s(scene.scan({0.0, 0.0, 0.0}));
    s.choose();
    bool inside = false;
    bool open = false;
    for (std::size_t i = 0; i < s.walls.left.size(); ++i) {
      inside |= s.walls.left.x[i] > 2.1F && s.walls.left.x[i] < static_cast<float>(1.9 + joint);
      const Point2 out = s.walls.left.outward[i];
      open |= std::abs(s.walls.left.x[i] - 2.0F) < 0.1F && (out.x != 0.0 || out.y != 0.0);
    }
    EXPECT_EQ(inside, joint < 0.9) << joint;
    EXPECT_EQ(open, joint > 0.9) << joint;
  }
}

TEST(Sides, a_side_ends_where_its_next_section_is_farther_away_than_chain_gap) {
  for (const double gap : {4.0, 6.0}) {
    scene::Scene scene;
    scene.add(scene::right, {{-5.0, -1.0}, {20.0, -1.0}});
    scene.add(scene::left, {{-5.0, 1.0}, {7.0 - gap, 1.0}}).add(scene::left, {{7.0, 1.0}, {9.5, 1.0}});
    Sides s(scene.scan({0.0, 0.0, 0.0}));
    s.choose();
    double farthest = 0.0;
    for (std::size_t i = 0; i < s.walls.left.size(); ++i)
      farthest = std::max(farthest, static_cast<double>(s.walls.left.x[i]));
    EXPECT_EQ(farthest > 9.0, gap < s.params.chain_gap) << gap;
  }
}

// The wall facing the car at the end of a straight has lost some beams; the track continues around the right wall.
TEST(Sides, the_track_does_not_continue_through_a_hole_in_one_wall) {
  scene::Scene corner;
  corner.add(scene::left, {{-4.0, 1.0}, {5.0, 1.0}, {5.0, -0.2}});
  corner.add(scene::left, {{5.0, -1.6}, {5.0, -4.5}, {-4.0, -4.5}});
  corner.add(scene::right, {{-4.0, -1.0}, {2.0, -1.0}, {2.0, -1.3}, {-4.0, -1.3}});
  Sides s(corner.scan({0.0, 0.0, 0.0}));
  s.choose();
  ASSERT_GT(s.candidates.count, 1U);
  double lowest = 1.0;
  for (std::size_t i = 0; i < s.walls.left.size(); ++i)
    lowest = std::min(lowest, static_cast<double>(s.walls.left.y[i]));
  EXPECT_LT(lowest, -2.0);
  for (std::size_t i = 0; i < s.walls.right.size(); ++i) EXPECT_LT(s.walls.right.x[i], 2.5F);
}

TEST(Sides, what_lies_past_the_end_of_a_wall_beside_the_car_keeps_its_previous_side) {
  scene::Scene hairpin;
  hairpin.add(scene::right, {{4.0, -1.0}, {-1.2, -1.0}});
  hairpin.add(scene::left, {{4.0, 1.0}, {0.0, 1.0}, {0.0, 1.2}, {4.0, 1.2}});
  hairpin.add(scene::right, {{-1.2, 2.0}, {-1.2, 3.2}});
  for (const bool known : {true, false}) {
    Sides s(hairpin.scan({0.0, 0.0, 0.0}));
    LocalWalls before;
    for (double y = 1.5; y < 3.6; y += 0.1)
      if (known) before.right.push(-1.2, y, {}, 0.0F);
    label_from_history(before, Buffer<TrajectoryPoint>(8), Buffer<TrailPoint>(8), s.params, s.samples);
    s.choose();
    for (std::size_t i = 0; i < s.walls.left.size(); ++i) EXPECT_LT(s.walls.left.y[i], 1.3F);
    bool is_right = false;
    for (std::size_t i = 0; i < s.walls.right.size(); ++i) is_right = is_right || s.walls.right.y[i] > 1.9F;
    EXPECT_EQ(is_right, known);
  }
}

}  // namespace
}  // namespace firstlap
