#include "firstlap/planning/spline.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace firstlap {
namespace {

Spline spline_through(const std::vector<Point2>& points) {
  Buffer<Point2> buffer(64);
  for (const Point2& p : points) buffer.push(p);
  Spline spline(64);
  EXPECT_TRUE(spline.fit(buffer));
  return spline;
}

const std::vector<Point2> knots = {{0, 0}, {0.5, 0.1}, {1.1, 0.4}, {1.4, 0.9}, {1.3, 1.6}, {0.8, 1.9}, {0.7, 2.8}};

// SciPy 1.x, printed by
//   p = np.array([[0,0],[0.5,0.1],[1.1,0.4],[1.4,0.9],[1.3,1.6],[0.8,1.9],[0.7,2.8]], float)
//   u = np.r_[0, np.cumsum(np.hypot(*np.diff(p, axis=0).T))]
//   s = scipy.interpolate.CubicSpline(u, p, bc_type="natural")
//   for t in [0, 0.25, 0.9, 1.3, 1.8, 2.2, 2.9, 3.3, u[-1]]:
//       (x, y), (dx, dy), (ddx, ddy) = s(t), s(t, 1), s(t, 2)
//       print(t, x, y, np.arctan2(dy, dx), (dx*ddy - dy*ddx) / np.hypot(dx, dy)**3)
constexpr double scipy[][5] = {
    {0, 0, 0, 0.161134164603484, 0},
    {0.25, 0.245448831611614, 0.0421033679382969, 0.187320916806086, 0.209066796632079},
    {0.9, 0.869732499973852, 0.242124447870848, 0.485841017110389, 0.718749259071415},
    {1.3, 1.18256330035999, 0.483823001205205, 0.854356927698674, 1.03949423836948},
    {1.8, 1.40952845163471, 0.937937949591786, 1.3411506064219, 0.839188350838768},
    {2.2, 1.42067557862484, 1.365659239955, 1.79553008396045, 1.51488476687392},
    {2.9, 0.922137016089092, 1.81803766826008, 2.65176165211175, -0.87213683144573},
    {3.3, 0.685525394144857, 2.0851629641599, 1.875786098698, -1.84862175916481},
    {3.95955801857856, 0.7, 2.8, 1.42709697483191, 0},
};

TEST(Spline, it_agrees_with_scipys_natural_cubic_spline) {
  const Spline spline = spline_through(knots);
  std::size_t hint = 0;
  for (const auto& row : scipy) {
    const SplineSample s = spline.at(row[0], hint);
    EXPECT_NEAR(s.x, row[1], 1e-12) << row[0];
    EXPECT_NEAR(s.y, row[2], 1e-12) << row[0];
    EXPECT_NEAR(s.yaw, row[3], 1e-12) << row[0];
    EXPECT_NEAR(s.curvature, row[4], 1e-11) << row[0];
  }
}

TEST(Spline, the_order_of_evaluation_does_not_matter) {
  const Spline spline = spline_through(knots);
  std::size_t hint = 0;
  for (int i = 100; i-- > 0;) {
    std::size_t fresh = 0;
    const double u = 0.04 * ((i * 37) % 100);
    EXPECT_EQ(spline.at(u, hint).x, spline.at(u, fresh).x);
  }
  std::size_t absurd = 1000;
  EXPECT_EQ(spline.at(1.0, absurd).y, spline.at(1.0, hint = 0).y);
}

TEST(Spline, it_passes_through_its_points) {
  const Spline spline = spline_through(knots);
  double u = 0.0;
  std::size_t hint = 0;
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (i > 0) u += std::hypot(knots[i].x - knots[i - 1].x, knots[i].y - knots[i - 1].y);
    EXPECT_NEAR(spline.at(u, hint).x, knots[i].x, 1e-12);
    EXPECT_NEAR(spline.at(u, hint).y, knots[i].y, 1e-12);
  }
}

TEST(Spline, yaw_and_curvature_are_continuous_at_the_knots) {
  const Spline spline = spline_through(knots);
  double u = 0.0;
  std::size_t hint = 0;
  for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
    u += std::hypot(knots[i].x - knots[i - 1].x, knots[i].y - knots[i - 1].y);
    const SplineSample before = spline.at(u - 1e-9, hint);
    const SplineSample after = spline.at(u + 1e-9, hint);
    EXPECT_NEAR(before.yaw, after.yaw, 1e-6);
    EXPECT_NEAR(before.curvature, after.curvature, 1e-6);
  }
}

TEST(Spline, it_never_extrapolates) {
  const Spline spline = spline_through(knots);
  std::size_t hint = 0;
  EXPECT_NEAR(spline.at(-5.0, hint).x, 0.0, 1e-12);
  EXPECT_NEAR(spline.at(1e300, hint).x, 0.7, 1e-12);
}

TEST(Spline, two_points_are_a_straight_line) {
  const Spline spline = spline_through({{1, 1}, {4, 5}});
  std::size_t hint = 0;
  EXPECT_DOUBLE_EQ(spline.length(), 5.0);
  EXPECT_NEAR(spline.at(2.5, hint).x, 2.5, 1e-12);
  EXPECT_NEAR(spline.at(2.5, hint).curvature, 0.0, 1e-12);
}

TEST(Spline, repeated_points_are_skipped) {
  const Spline once = spline_through({{0, 0}, {1, 1}, {2, 0}});
  const Spline twice = spline_through({{0, 0}, {0, 0}, {1, 1}, {1, 1}, {1, 1}, {2, 0}, {2, 0}});
  std::size_t hint = 0;
  EXPECT_DOUBLE_EQ(once.length(), twice.length());
  EXPECT_EQ(once.at(0.7, hint).y, twice.at(0.7, hint).y);
}

TEST(Spline, fewer_than_two_different_points_are_refused) {
  Spline spline(8);
  Buffer<Point2> points(8);
  EXPECT_FALSE(spline.fit(points));
  points.push({1, 1});
  EXPECT_FALSE(spline.fit(points));
  points.push({1, 1});
  EXPECT_FALSE(spline.fit(points));
}

}  // namespace
}  // namespace firstlap
