// Distance to the nearest wall of an occupancy map, for every cell: what a return is weighed by
// (Thrun, Burgard and Fox, Probabilistic Robotics, 6.4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"
#include "firstlap/mapping/cloud.hpp"

namespace firstlap::localization {

struct Beam {
  float x = 0.0F, y = 0.0F;  // [m] of a return, in base_link
};

inline constexpr int farthest_mm = 2000;  // distances end here

class LikelihoodField {
 public:
  // `occupied`: columns x rows, row 0 the lowest, not 0 where a wall stands. `origin`: the lower left corner's
  // pose in the map's frame. Throws std::invalid_argument for sizes that do not fit, or a map without walls.
  LikelihoodField(std::span<const std::uint8_t> occupied, int columns, int rows, double resolution,
                  const Pose2& origin);

  // Poses of the map's frame in the field's own (meters from the lower left corner), and back.
  [[nodiscard]] Pose2 to_field(const Pose2& in_map) const noexcept;
  [[nodiscard]] Pose2 to_map(const Pose2& in_field) const noexcept;

  // [mm] to the nearest wall from a point of the field's frame [m], in steps of a cell; farthest_mm outside.
  [[nodiscard]] int distance_mm(float x, float y) const noexcept {
    const float column = x * scale_, row = y * scale_;
    // Also false for NaN.
    if (!(column >= 0.0F && row >= 0.0F && column < columns_f_ && row < rows_f_)) return farthest_mm;
    return mm_[static_cast<std::size_t>(row) * stride_ + static_cast<std::size_t>(column)];
  }

  // Distance [m] between the cells' centres, linear, with its slope; far with slope 0 outside.
  struct Slope {
    double distance, dx, dy;
  };
  [[nodiscard]] Slope slope(double x, double y) const noexcept;

  [[nodiscard]] int columns() const noexcept { return columns_; }
  [[nodiscard]] int rows() const noexcept { return rows_; }
  [[nodiscard]] double resolution() const noexcept { return resolution_; }

 private:
  int columns_, rows_;
  std::size_t stride_;
  double resolution_;
  Pose2 origin_;
  float scale_, columns_f_, rows_f_;
  std::vector<std::uint16_t> mm_;
};

// A field round a few clouds in one frame, for a coarse search.
LikelihoodField field_of(std::span<const mapping::CloudPoint> points, double resolution);

// Where the beams fit best within `radius` [m] and `angle` [rad] of `guess`, tried on a raster of `step` [m] and
// `turn` [rad]; `fit` is the share of beams that end within one step of a wall.
struct SearchResult {
  Pose2 pose{};
  double fit = 0.0;
};
struct SearchWindow {
  double radius, angle, step, turn;
};
SearchResult search(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& guess,
                    const SearchWindow& window) noexcept;

}  // namespace firstlap::localization
