#include "firstlap/mapping/occupancy_grid.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace firstlap::mapping {
namespace {

// Next crossing of a ray into another column or row, in units of its length.
struct Crossing {
  Crossing(double from, double to, int cell) : step(to > from ? 1 : -1) {
    const double length = std::abs(to - from);
    if (length < 1e-12) return;
    each = 1.0 / length;
    next = (to > from ? cell + 1 - from : from - cell) / length;
  }
  int step;
  double each = std::numeric_limits<double>::infinity();
  double next = std::numeric_limits<double>::infinity();
};

}  // namespace

OccupancyGrid::OccupancyGrid(double x, double y, int columns, int rows, const GridParams& params)
    : params_(params), x_(x), y_(y), columns_(columns), rows_(rows) {
  if (columns < 1 || rows < 1 ||
      static_cast<double>(columns) * static_cast<double>(rows) > static_cast<double>(max_grid_cells)) {
    throw std::invalid_argument("a map of " + std::to_string(columns) + " x " + std::to_string(rows) +
                                " cells; allowed are 1 to " + std::to_string(max_grid_cells) +
                                " in total (a larger grid.resolution gives fewer)");
  }
  counts_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
}

void OccupancyGrid::add(const Pose2& pose, const Point2& laser, std::span<const ScanPoint> points) noexcept {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw), scale = 1.0 / params_.resolution;
  const auto column = [&](double x, double y) { return (pose.x + c * x - s * y - x_) * scale; };
  const auto row = [&](double x, double y) { return (pose.y + s * x + c * y - y_) * scale; };
  if (!std::isfinite(column(laser.x, laser.y)) || !std::isfinite(row(laser.x, laser.y))) return;
  for (const ScanPoint& p : points) {
    if (p.range > params_.range_use) continue;
    add_ray(column(laser.x, laser.y), row(laser.x, laser.y), column(p.x, p.y), row(p.x, p.y));
  }
}

// Coordinates in cells. Visits every cell on the ray (Amanatides and Woo 1987). Both ends must be within the map.
void OccupancyGrid::add_ray(double x0, double y0, double x1, double y1) noexcept {
  const auto fits = [](double v, int size) { return v >= 0.0 && v < size; };
  if (!fits(x0, columns_) || !fits(x1, columns_) || !fits(y0, rows_) || !fits(y1, rows_)) return;
  int column = static_cast<int>(x0), row = static_cast<int>(y0);
  const int last_column = static_cast<int>(x1), last_row = static_cast<int>(y1);
  Crossing along_x(x0, x1, column), along_y(y0, y1, row);
  const int cells = std::abs(last_column - column) + std::abs(last_row - row);
  for (int i = 0; i < cells && (column != last_column || row != last_row); ++i) {
    Count& count = at(column, row);
    if (count.passes < std::numeric_limits<std::uint16_t>::max()) ++count.passes;
    Crossing& nearer = along_x.next < along_y.next ? along_x : along_y;
    (along_x.next < along_y.next ? column : row) += nearer.step;
    nearer.next += nearer.each;
    if (!inside(column, row)) return;
  }
  Count& count = at(last_column, last_row);
  if (count.passes == std::numeric_limits<std::uint16_t>::max()) return;
  ++count.passes;
  ++count.hits;
}

Cell OccupancyGrid::cell(int column, int row) const noexcept {
  if (!inside(column, row)) return Cell::unknown;
  const Count& count = const_cast<OccupancyGrid*>(this)->at(column, row);
  if (count.passes < params_.min_passes) return Cell::unknown;
  return count.hits >= params_.occupied_ratio * count.passes ? Cell::occupied : Cell::free;
}

bool OccupancyGrid::inside(int column, int row) const noexcept {
  return column >= 0 && row >= 0 && column < columns_ && row < rows_;
}

OccupancyGrid::Count& OccupancyGrid::at(int column, int row) noexcept {
  return counts_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
}

}  // namespace firstlap::mapping
