// Distance to the nearest wall of an occupancy map for every cell, used to weight returns (Thrun, Burgard and Fox,
// Probabilistic Robotics, 6.4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"
#include "firstlap/mapping/cloud.hpp"

namespace firstlap::localization {

struct Beam {
  float x = 0.0F, y = 0.0F;  // [m] end point of the beam in base_link
};

inline constexpr int max_distance_mm = 2000;  // [mm] maximum distance

class LikelihoodField {
 public:
  // `occupied`: columns x rows, row 0 the lowest, nonzero for walls. `resolution`: [m] cell size. `origin`: pose of the
  // lower left corner in the map's frame. Throws std::invalid_argument for inconsistent sizes, or a map without walls.
  LikelihoodField(std::span<const std::uint8_t> occupied, int columns, int rows, double resolution,
                  const Pose2& origin);

  // Transforms poses from the map's frame to the field's (meters from the lower left corner), and back.
  [[nodiscard]] Pose2 to_field(const Pose2& in_map) const noexcept;
  [[nodiscard]] Pose2 to_map(const Pose2& in_field) const noexcept;

  // [mm] distance to the nearest wall from a point in the field's frame [m], constant per cell; max_distance_mm
  // outside.
  [[nodiscard]] int distance_mm(float x, float y) const noexcept {
    const float column = x * scale_, row = y * scale_;
    // Also false for NaN.
    if (!(column >= 0.0F && row >= 0.0F && column < columns_f_ && row < rows_f_)) return max_distance_mm;
    return mm_[static_cast<std::size_t>(row) * stride_ + static_cast<std::size_t>(column)];
  }

  // Distance [m], interpolated linearly between cell centers, with its gradient; the maximum with gradient 0 outside.
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

// A field of a few clouds in one frame, for a coarse search.
LikelihoodField field_of(std::span<const mapping::CloudPoint> points, double resolution);

// Exhaustive search for the best pose within `radius` [m] and `angle` [rad] of `guess` (in the map's frame), on a grid
// of `step` [m] and `turn` [rad]. `fit` is the share of beams that end within one step of a wall.
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
