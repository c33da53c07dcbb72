// Step 1: beams to points in base_link at the end of the sweep.
#pragma once

#include <cstddef>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/params.hpp"

namespace firstlap {

inline constexpr std::size_t max_points = 2048;  // per scan; denser scans are thinned evenly

struct ScanPoint {
  double x = 0.0;      // [m] base_link
  double y = 0.0;      // [m] base_link
  double range = 0.0;  // [m] from the LiDAR
  int beam = 0;        // index among the used beams, right to left

  static constexpr auto columns() {
    using C = ScanPoint;
    return std::tuple{
        Column{"points",
               [](const C& p) {
                 return Point2{p.x, p.y};
               },
               "m", "valid returns, right to left"},
        Column{"point_range", &C::range, "m", "range of each point from the LiDAR"},
        Column{"point_beam", &C::beam, "", "index of each point's beam among the used beams, right to left"},
    };
  }
};

// Directions of the used beams, right to left, for any first beam and direction of rotation: the seam is rotated behind
// the car. If the beams cross the direction straight behind, the table has a slot for every beam of a full turn, and
// slots without a beam are empty. The table is reused while the scan header stays the same.
class BeamTable {
 public:
  static constexpr std::ptrdiff_t no_source = -1;  // source of an empty slot

  BeamTable();

  // Rebuilds the table if the scan's header changed. Returns false for an invalid header; the table must not be used
  // then.
  bool prepare(const LaserScan& scan) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return cos_.size(); }
  [[nodiscard]] double angle_step() const noexcept { return step_; }    // [rad] between used beams, > 0
  [[nodiscard]] double angle_first() const noexcept { return first_; }  // [rad] of the rightmost used beam
  // [rad] of used beam i, increasing. Where a full turn closes, the step may differ slightly.
  [[nodiscard]] double angle(std::size_t i) const noexcept {
    return i < seam_ ? first_ + step_ * static_cast<double>(i) : second_ + step_ * static_cast<double>(i - seam_);
  }
  [[nodiscard]] double cosine(std::size_t i) const noexcept { return cos_[i]; }
  [[nodiscard]] double sine(std::size_t i) const noexcept { return sin_[i]; }
  // Index of used beam i in LaserScan::ranges, or no_source.
  [[nodiscard]] std::ptrdiff_t source(std::size_t i) const noexcept { return source_[i]; }

 private:
  void lay_out(const LaserScan& scan) noexcept;
  void add(double angle, std::ptrdiff_t source) noexcept;

  double angle_min_ = 0.0;
  double angle_increment_ = 0.0;
  std::size_t beams_ = 0;
  double first_ = 0.0;
  double step_ = 0.0;
  double second_ = 0.0;   // [rad] of slot `seam_`
  std::size_t seam_ = 0;  // slot of the scan's first beam; past the last slot if the scan is not rotated
  Buffer<double> cos_;
  Buffer<double> sin_;
  Buffer<std::ptrdiff_t> source_;
};

// Converts valid returns to points in scan order (right to left), deskewed with `state`. Drops invalid returns, the
// car's own body and points far behind.
void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept;

}  // namespace firstlap
