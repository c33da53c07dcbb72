#include "firstlap/common/rng.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace firstlap::sim {
namespace {

TEST(Rng, gives_the_same_numbers_everywhere) {
  Rng rng(1);
  const std::uint64_t first = rng.next();
  EXPECT_EQ(first, Rng(1).next());
  EXPECT_NE(first, Rng(2).next());
  EXPECT_NE(first, Rng(1, 1).next());
  Rng normal(42);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) sum += normal.gaussian();
  EXPECT_NEAR(sum, -29.528116553638302, 1e-10);
}

TEST(Rng, uniform_fills_the_unit_interval) {
  Rng rng(7);
  double sum = 0.0, low = 1.0, high = 0.0;
  for (int i = 0; i < 1000000; ++i) {
    const double u = rng.uniform();
    sum += u;
    low = std::min(low, u);
    high = std::max(high, u);
  }
  EXPECT_NEAR(sum / 1e6, 0.5, 1.5e-3);
  EXPECT_GE(low, 0.0);
  EXPECT_LT(high, 1.0);
}

TEST(Rng, gaussian_has_normal_moments_and_tails) {
  Rng rng(8);
  constexpr int n = 4000000;
  double m1 = 0.0, m2 = 0.0, m3 = 0.0, m4 = 0.0;
  int beyond_one = 0, beyond_two = 0, beyond_four = 0, right_tail = 0;
  for (int i = 0; i < n; ++i) {
    const double x = rng.gaussian();
    m1 += x;
    m2 += x * x;
    m3 += x * x * x;
    m4 += x * x * x * x;
    beyond_one += std::abs(x) > 1.0;
    beyond_two += std::abs(x) > 2.0;
    beyond_four += std::abs(x) > 3.6;
    right_tail += x > 3.6;
  }
  EXPECT_NEAR(m1 / n, 0.0, 2.5e-3);
  EXPECT_NEAR(m2 / n, 1.0, 4e-3);
  EXPECT_NEAR(m3 / n, 0.0, 8e-3);
  EXPECT_NEAR(m4 / n, 3.0, 3e-2);
  EXPECT_NEAR(1.0 * beyond_one / n, 0.317311, 1e-3);
  EXPECT_NEAR(1.0 * beyond_two / n, 0.045500, 5e-4);
  EXPECT_NEAR(1.0 * beyond_four / n, 3.182e-4, 4e-5);
  EXPECT_NEAR(2.0 * right_tail / beyond_four, 1.0, 0.15);
}

}  // namespace
}  // namespace firstlap::sim
