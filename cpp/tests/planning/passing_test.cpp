#include "firstlap/planning/passing.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap {
namespace {

Centerline line_with_room(double half_width, double narrow_at, double narrow_half_width) {
  Centerline line;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.15 * i;
    const double half = std::abs(x - narrow_at) < 0.2 ? narrow_half_width : half_width;
    line.points.push({x, 0.0, 2.0 * half, WallSupport::both, {x, -half}, {x, half}});
  }
  return line;
}

TEST(Passing, clearance_on_both_sides_scores_1_and_a_tight_place_less) {
  const CarGeometry car;
  EXPECT_EQ(clearance_score(line_with_room(0.9, 100.0, 0.0), car, {}), 1.0);
  EXPECT_LT(clearance_score(line_with_room(0.9, 2.0, 0.25), car, {}), 0.6);
  EXPECT_GT(clearance_score(line_with_room(0.9, 2.0, 0.30), car, {}),
            clearance_score(line_with_room(0.9, 2.0, 0.25), car, {}));
}

TEST(Passing, a_tight_place_far_ahead_does_not_count) {
  EXPECT_EQ(clearance_score(line_with_room(0.9, 7.0, 0.2), CarGeometry{}, {}), 1.0);
}

TEST(Passing, a_section_that_changes_sides_lowers_the_score_and_a_small_or_unknown_one_does_not) {
  Buffer<Section> sections(8);
  Buffer<SectionSample> samples(64);
  for (int i = 0; i < 3; ++i) sections.push({});
  const int votes[] = {-1, -1, 1};  // right wall, a box passed on its left, left wall
  for (std::size_t s = 0; s < 3; ++s)
    for (int k = 0; k < 5; ++k) samples.push({1.0, 0.0, s, votes[s]});
  EXPECT_EQ(side_consistency(sections, samples, 2, {}), 1.0);
  EXPECT_LT(side_consistency(sections, samples, 1, {}), 0.7);
  EXPECT_LT(side_consistency(sections, samples, 0, {}), side_consistency(sections, samples, 1, {}));
  for (SectionSample& sample : samples) sample.vote = sample.section == 1 ? 0 : sample.vote;
  EXPECT_EQ(side_consistency(sections, samples, 1, {}), 1.0);
  for (SectionSample& sample : samples) sample.vote = sample.section == 1 ? -1 : sample.vote;
  sections[1].status = SectionStatus::too_small;
  EXPECT_EQ(side_consistency(sections, samples, 1, {}), 1.0);
}

}  // namespace
}  // namespace firstlap
