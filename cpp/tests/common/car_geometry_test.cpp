#include "firstlap/common/car_geometry.hpp"

#include <gtest/gtest.h>

namespace firstlap {
namespace {

TEST(Footprint, covers_exactly_the_body_and_its_margin) {
  const CarGeometry car{.width = 0.3, .length = 0.6, .rear_overhang = 0.1};
  for (const double margin : {0.0, 0.05}) {
    const Footprint body(car, margin);
    const double front = 0.5 + margin, rear = -0.1 - margin, side = 0.15 + margin, bit = 1e-6;
    for (const double y : {-side + bit, 0.0, side - bit}) {
      EXPECT_TRUE(body.covers({front - bit, y})) << margin << ' ' << y;
      EXPECT_TRUE(body.covers({rear + bit, y})) << margin << ' ' << y;
      EXPECT_FALSE(body.covers({front + bit, y})) << margin << ' ' << y;
      EXPECT_FALSE(body.covers({rear - bit, y})) << margin << ' ' << y;
    }
    EXPECT_FALSE(body.covers({0.0, side + bit})) << margin;
    EXPECT_FALSE(body.covers({0.0, -side - bit})) << margin;
  }
}

}  // namespace
}  // namespace firstlap
