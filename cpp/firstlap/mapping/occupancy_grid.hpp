// An occupancy map from scans with known poses. For each cell it counts the beams that met the cell and those that
// ended in it (the reflection map of Burgard et al., also used by Karto).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"
#include "firstlap/mapping/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap::mapping {

inline constexpr std::size_t max_grid_cells = 64'000'000;

enum class Cell : std::uint8_t { free, occupied, unknown };

class OccupancyGrid {
 public:
  // (x, y) is the lower left corner [m]; row 0 is the lowest. Throws std::invalid_argument for a size below 1 or above
  // max_grid_cells.
  OccupancyGrid(double x, double y, int columns, int rows, const GridParams& params);

  // Adds the returns of one scan: `points` and `laser` (the LiDAR's position) in base_link, with base_link at `pose` in
  // the map. Beams that leave the map are ignored.
  void add(const Pose2& pose, const Point2& laser, std::span<const ScanPoint> points) noexcept;

  [[nodiscard]] Cell cell(int column, int row) const noexcept;
  [[nodiscard]] int columns() const noexcept { return columns_; }
  [[nodiscard]] int rows() const noexcept { return rows_; }

 private:
  struct Count {
    std::uint16_t passes = 0, hits = 0;
  };

  void add_ray(double x0, double y0, double x1, double y1) noexcept;
  [[nodiscard]] bool inside(int column, int row) const noexcept;
  Count& at(int column, int row) noexcept;

  GridParams params_;
  double x_, y_;
  int columns_, rows_;
  std::vector<Count> counts_;
};

}  // namespace firstlap::mapping
