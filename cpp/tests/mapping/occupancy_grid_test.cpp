#include "firstlap/mapping/occupancy_grid.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

namespace firstlap::mapping {
namespace {

GridParams meter_cells() {
  GridParams params;
  params.resolution = 1.0;
  params.min_passes = 1;
  params.range_use = 60.0;
  return params;
}

ScanPoint at(double x, double y) { return {x, y, std::hypot(x, y), 0}; }

TEST(OccupancyGrid, a_ray_frees_the_cells_it_crosses_and_occupies_the_one_where_it_ends) {
  OccupancyGrid grid(0.0, 0.0, 8, 3, meter_cells());
  const std::vector<ScanPoint> points{at(5.0, 0.0)};
  grid.add({0.5, 1.5, 0.0}, {0.0, 0.0}, points);
  for (int column = 0; column < 8; ++column) {
    const Cell wanted = column < 5 ? Cell::free : column == 5 ? Cell::occupied : Cell::unknown;
    EXPECT_EQ(grid.cell(column, 1), wanted) << column;
    EXPECT_EQ(grid.cell(column, 0), Cell::unknown);
    EXPECT_EQ(grid.cell(column, 2), Cell::unknown);
  }
}

TEST(OccupancyGrid, a_slanted_ray_leaves_no_gap) {
  OccupancyGrid grid(0.0, 0.0, 10, 10, meter_cells());
  const std::vector<ScanPoint> points{at(8.1, 5.3)};
  grid.add({0.5, 0.5, 0.0}, {0.0, 0.0}, points);
  int column = 0, row = 0, met = 1;
  while (grid.cell(column, row) == Cell::free) {
    const bool right = grid.cell(column + 1, row) != Cell::unknown;
    const bool up = grid.cell(column, row + 1) != Cell::unknown;
    ASSERT_NE(right, up) << "one next cell from " << column << " " << row;
    (right ? column : row) += 1;
    ++met;
  }
  EXPECT_EQ(column, 8);
  EXPECT_EQ(row, 5);
  EXPECT_EQ(met, 14);
}

TEST(OccupancyGrid, the_ray_follows_the_pose_and_the_mounting) {
  OccupancyGrid grid(-5.0, -5.0, 10, 10, meter_cells());
  const std::vector<ScanPoint> points{at(3.0, 0.0)};
  grid.add({0.5, 0.5, 0.5 * 3.14159265358979}, {1.0, 0.0}, points);  // facing +y, the LiDAR 1 m ahead
  EXPECT_EQ(grid.cell(5, 8), Cell::occupied);
  EXPECT_EQ(grid.cell(5, 7), Cell::free);
  EXPECT_EQ(grid.cell(5, 6), Cell::free);
  EXPECT_EQ(grid.cell(5, 5), Cell::unknown) << "unknown behind the LiDAR";
}

TEST(OccupancyGrid, one_stray_return_does_not_outweigh_many_beams) {
  GridParams params = meter_cells();
  params.occupied_ratio = 0.2;
  OccupancyGrid grid(0.0, 0.0, 8, 1, params);
  const std::vector<ScanPoint> stray{at(3.0, 0.0)}, wall{at(6.0, 0.0)};
  grid.add({0.5, 0.5, 0.0}, {0.0, 0.0}, stray);
  EXPECT_EQ(grid.cell(3, 0), Cell::occupied);
  for (int i = 0; i < 10; ++i) grid.add({0.5, 0.5, 0.0}, {0.0, 0.0}, wall);
  EXPECT_EQ(grid.cell(3, 0), Cell::free);
  EXPECT_EQ(grid.cell(6, 0), Cell::occupied);
}

TEST(OccupancyGrid, points_outside_or_invalid_change_nothing) {
  OccupancyGrid grid(0.0, 0.0, 4, 4, meter_cells());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<ScanPoint> points{at(50.0, 0.0), at(nan, 0.0), at(-3.0, 0.0)};
  grid.add({1.5, 1.5, 0.0}, {0.0, 0.0}, points);
  grid.add({nan, 1.5, 0.0}, {0.0, 0.0}, points);
  for (int row = -1; row <= 4; ++row) {
    for (int column = -1; column <= 4; ++column) EXPECT_EQ(grid.cell(column, row), Cell::unknown);
  }
}

TEST(OccupancyGrid, a_map_of_invalid_size_is_refused) {
  EXPECT_THROW(OccupancyGrid(0.0, 0.0, 1 << 20, 1 << 20, {}), std::invalid_argument);
  EXPECT_THROW(OccupancyGrid(0.0, 0.0, 0, 5, {}), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::mapping
