// The walls of a track: straight segments in the map frame [m], with a uniform grid for neighborhood queries, and the
// visible segments arranged for the LiDAR. Immutable once built: many races may share one instance.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"

namespace firstlap::sim {

struct WallSegment {
  double x1 = 0.0, y1 = 0.0, x2 = 0.0, y2 = 0.0;  // [m]
  bool visible = true;                            // seen by the LiDAR
  bool solid = true;                              // not passable for the car
};

// A connected run of visible segments, vertices [first, first + count) of `VisibleWalls`, with its bounding circle.
struct WallBlock {
  std::size_t first = 0;
  std::size_t count = 0;
  double x = 0.0, y = 0.0, radius = 0.0;  // [m]
};

struct VisibleWalls {
  std::vector<double> x, y;  // [m]
  std::vector<WallBlock> blocks;
};

class Walls {
 public:
  Walls() = default;

  // Scans are faster if segments follow each other as polylines (each end equals the next start). Throws
  // std::invalid_argument for a coordinate that is not finite or a cell size [m] that is not positive.
  explicit Walls(std::vector<WallSegment> segments, double cell_size = 1.0);

  std::span<const WallSegment> segments() const noexcept { return segments_; }
  const VisibleWalls& visible() const noexcept { return visible_; }

  // Calls visit(index) once for each of a superset of the segments within `radius` [m] of `center`.
  template <class Visitor>
  void for_each_near(Point2 center, double radius, Visitor&& visit) const;

  // Indices of the segments within `radius` [m] of `center`. Returns their number and writes as many as fit in `out`.
  std::size_t near(Point2 center, double radius, std::span<std::uint32_t> out) const;

  // The smallest distance(index) [m] of a solid segment; +inf without one. No segment may be farther from `center` than
  // its distance(index) plus `slack` [m].
  template <class Distance>
  double nearest_solid(Point2 center, double slack, Distance&& distance) const;

  // Distance [m] from `point` to the nearest solid segment; +inf without one.
  double nearest_distance(Point2 point) const;

  // Reference for tests: range [m] of a ray from `pose` at `angle` [rad] from its heading, by intersection with every
  // visible segment; +inf without a hit.
  double raycast_brute_force(const Pose2& pose, double angle) const;

 private:
  struct CellRange {
    std::int32_t x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  };

  CellRange cells_of(double min_x, double min_y, double max_x, double max_y) const;
  CellRange cells_of(const WallSegment& segment) const;
  bool covers_all(const CellRange& range) const noexcept;
  void place_grid();
  void build_grid();
  void build_visible();
  void append_visible(const WallSegment& segment);

  std::vector<WallSegment> segments_;
  VisibleWalls visible_;
  double cell_size_ = 1.0;
  double origin_x_ = 0.0, origin_y_ = 0.0;
  std::int32_t columns_ = 0, rows_ = 0;
  std::vector<CellRange> ranges_;          // cells of each segment's bounding box
  std::vector<std::uint32_t> cell_start_;  // into cell_items_, one more than there are cells
  std::vector<std::uint32_t> cell_items_;
};

// Range [m] from the origin along the unit vector `beam` to a segment; +inf without a hit.
double range_along(Point2 beam, const WallSegment& segment) noexcept;

// Distance [m] from a point to a segment.
double distance(Point2 point, const WallSegment& segment) noexcept;

// A segment is listed in every cell of its bounding box and reported by the first of them inside the query.
template <class Visitor>
void Walls::for_each_near(Point2 center, double radius, Visitor&& visit) const {
  if (segments_.empty()) return;
  const CellRange query = cells_of(center.x - radius, center.y - radius, center.x + radius, center.y + radius);
  for (std::int32_t row = query.y0; row <= query.y1; ++row) {
    for (std::int32_t column = query.x0; column <= query.x1; ++column) {
      const auto cell =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
      for (std::uint32_t k = cell_start_[cell]; k < cell_start_[cell + 1]; ++k) {
        const CellRange& own = ranges_[cell_items_[k]];
        const bool first_x = column == own.x0 || (column == query.x0 && own.x0 < query.x0);
        const bool first_y = row == own.y0 || (row == query.y0 && own.y0 < query.y0);
        if (first_x && first_y) visit(static_cast<std::size_t>(cell_items_[k]));
      }
    }
  }
}

template <class Distance>
double Walls::nearest_solid(Point2 center, double slack, Distance&& distance) const {
  for (double radius = 1.0;; radius *= 2.0) {
    const double reach = radius + slack;
    double best = std::numeric_limits<double>::infinity();
    for_each_near(center, reach, [&](std::size_t i) {
      if (segments_[i].solid) best = std::min(best, distance(i));
    });
    const CellRange query = cells_of(center.x - reach, center.y - reach, center.x + reach, center.y + reach);
    if (best <= radius || covers_all(query) || !(radius < 1e9)) return best;
  }
}

}  // namespace firstlap::sim
