#include "firstlap/perception/track_width.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace firstlap {
namespace {

TEST(TrackWidth, before_any_pair_it_is_the_remembered_width) { EXPECT_DOUBLE_EQ(LocalWidth(1.7, {}).value(), 1.7); }

TEST(TrackWidth, it_is_the_moving_average_of_the_last_window) {
  LocalWidth width(2.0, {});
  for (const double w : {9.0, 1.0, 1.0, 2.0, 2.0, 3.0}) width.observe(w);
  EXPECT_DOUBLE_EQ(width.value(), 1.8) << "mean of the last five";
}

TEST(TrackWidth, a_step_from_1_m_to_2_m_is_followed_within_one_window) {
  LocalWidth width(1.0, {});
  for (int i = 0; i < 10; ++i) width.observe(1.0);
  for (int i = 0; i < 5; ++i) width.observe(2.0);
  EXPECT_DOUBLE_EQ(width.value(), 2.0);
}

TEST(TrackWidth, beyond_the_last_pair_it_blends_into_the_remembered_width_over_4_m) {
  LocalWidth width(2.0, {});
  for (int i = 0; i < 5; ++i) width.observe(1.0);
  EXPECT_DOUBLE_EQ(width.value(), 1.0);
  width.miss(1.0);
  EXPECT_DOUBLE_EQ(width.value(), 1.25);
  width.miss(1.0);
  EXPECT_DOUBLE_EQ(width.value(), 1.5);
  width.miss(9.0);
  EXPECT_DOUBLE_EQ(width.value(), 2.0);
}

TEST(TrackWidth, a_new_pair_ends_the_blending) {
  LocalWidth width(2.0, {});
  for (int i = 0; i < 5; ++i) width.observe(1.0);
  width.miss(3.0);
  width.observe(1.0);
  EXPECT_DOUBLE_EQ(width.value(), 1.0);
}

TEST(TrackWidth, every_window_that_the_table_allows_works) {
  for (int window = 1; window <= max_width_window; ++window) {
    TrackWidthParams params;
    params.width_window = window;
    LocalWidth width(2.0, params);
    for (int i = 0; i < 60; ++i) width.observe(i < 30 ? 1.0 : 3.0);
    EXPECT_DOUBLE_EQ(width.value(), 3.0);
  }
}

TEST(TrackWidth, the_remembered_width_moves_by_its_gain_toward_the_median) {
  std::vector<double> widths{1.0, 9.0, 1.0, 1.0, 0.8};
  EXPECT_DOUBLE_EQ(remember_width(2.0, widths, 0.05, {}), 1.95);
}

TEST(TrackWidth, fewer_than_three_pairs_are_ignored) {
  std::vector<double> widths{1.0, 1.0};
  EXPECT_DOUBLE_EQ(remember_width(2.0, widths, 0.05, {}), 2.0);
  EXPECT_DOUBLE_EQ(remember_width(2.0, {}, 0.05, {}), 2.0);
}

TEST(TrackWidth, the_remembered_width_stays_within_the_pair_limits) {
  double width = 2.0;
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> absurd{50.0, 60.0, 70.0};
    width = remember_width(width, absurd, 0.05, {});
  }
  EXPECT_LE(width, TrackWidthParams{}.width_max);
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> absurd{0.1, 0.1, 0.1};
    width = remember_width(width, absurd, 0.05, {});
  }
  EXPECT_GE(width, TrackWidthParams{}.width_min);
}

}  // namespace
}  // namespace firstlap
