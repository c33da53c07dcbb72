#include "firstlap/estimation/gaussian.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap {
namespace {

using Pair = Gaussian<2>;

TEST(Gaussian, a_correction_is_the_closed_form_of_one_number) {
  Gaussian<1> belief{.mean = {1.0}, .covariance = {{{4.0}}}};
  belief.correct({1.0}, 3.0 - 1.0, 1.0);
  EXPECT_DOUBLE_EQ(belief.mean[0], 1.0 + 4.0 / 5.0 * 2.0);
  EXPECT_DOUBLE_EQ(belief.covariance[0][0], 4.0 / 5.0);
}

TEST(Gaussian, a_correction_moves_what_is_correlated_and_leaves_the_rest) {
  Pair belief{.mean = {0.0, 5.0}, .covariance = {{{2.0, 1.0}, {1.0, 3.0}}}};
  belief.correct({1.0, 0.0}, 1.0, 2.0);
  EXPECT_DOUBLE_EQ(belief.mean[0], 0.5);
  EXPECT_DOUBLE_EQ(belief.mean[1], 5.25);
  EXPECT_DOUBLE_EQ(belief.covariance[0][0], 1.0);
  EXPECT_DOUBLE_EQ(belief.covariance[0][1], 0.5);
  EXPECT_DOUBLE_EQ(belief.covariance[1][1], 2.75);
}

TEST(Gaussian, spreading_is_the_transitions_congruence_and_the_noise) {
  Pair belief{.covariance = {{{2.0, 1.0}, {1.0, 3.0}}}};
  belief.propagate({{{1.0, 0.5}, {0.0, 1.0}}}, {0.1, 0.2});
  EXPECT_DOUBLE_EQ(belief.covariance[0][0], 2.0 + 2.0 * 0.5 * 1.0 + 0.25 * 3.0 + 0.1);
  EXPECT_DOUBLE_EQ(belief.covariance[0][1], 1.0 + 0.5 * 3.0);
  EXPECT_DOUBLE_EQ(belief.covariance[1][0], belief.covariance[0][1]);
  EXPECT_DOUBLE_EQ(belief.covariance[1][1], 3.2);
}

TEST(Gaussian, the_innovations_variance_is_of_belief_and_noise) {
  const Pair belief{.covariance = {{{2.0, 1.0}, {1.0, 3.0}}}};
  EXPECT_DOUBLE_EQ(belief.innovation_variance({1.0, 2.0}, 0.5), 2.0 + 2.0 * 2.0 + 4.0 * 3.0 + 0.5);
}

// Nearly the same exact measurement again and again, of numbers whose scales differ by 1e8: the short form P - K h' P
// loses a variance here.
TEST(Gaussian, stays_symmetric_and_positive_whatever_is_rounded) {
  Pair belief{.covariance = {{{1e8, 0.0}, {0.0, 1.0}}}};
  for (int i = 0; i < 10000; ++i) {
    belief.correct({1.0, 1e-4 * (i % 3)}, 0.1, 1e-8);
    const auto& p = belief.covariance;
    ASSERT_EQ(p[0][1], p[1][0]);
    ASSERT_GT(p[0][0], 0.0);
    ASSERT_GT(p[1][1], 0.0);
    ASSERT_GE(p[0][0] * p[1][1] - p[0][1] * p[0][1], 0.0) << i;
  }
}

TEST(Gaussian, scaling_keeps_the_correlation) {
  Pair belief{.covariance = {{{4.0, 1.0}, {1.0, 1.0}}}};
  belief.scale(0, 0.5);
  EXPECT_DOUBLE_EQ(belief.covariance[0][0], 1.0);
  EXPECT_DOUBLE_EQ(belief.covariance[0][1], 0.5);
  EXPECT_DOUBLE_EQ(belief.covariance[1][0], 0.5);
  EXPECT_DOUBLE_EQ(belief.covariance[1][1], 1.0);
}

}  // namespace
}  // namespace firstlap
