// Step 1: beams to points in base_link at the end of the sweep.
#pragma once

#include <cstddef>

#include "firstlap/buffer.hpp"
#include "firstlap/params.hpp"
#include "firstlap/types.hpp"

namespace firstlap {

inline constexpr std::size_t max_points = 2048;  // of one scan; denser scans are thinned evenly

struct ScanPoint {
  double x = 0.0;      // [m] base_link
  double y = 0.0;      // [m] base_link
  double range = 0.0;  // [m] from the laser
  int beam = 0;        // index among the beams used, right to left
};

// Cosine and sine of the beams used, right to left; kept between scans of one shape.
class BeamTable {
 public:
  BeamTable();

  // Rebuilds the table where the scan's shape differs from the last one. False where the header makes
  // no sense: then nothing may be read.
  bool prepare(const LaserScan& scan) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return cos_.size(); }
  [[nodiscard]] double angle_step() const noexcept { return step_; }    // [rad] between used beams, > 0
  [[nodiscard]] double angle_first() const noexcept { return first_; }  // [rad] of the rightmost beam used
  [[nodiscard]] double cosine(std::size_t i) const noexcept { return cos_[i]; }
  [[nodiscard]] double sine(std::size_t i) const noexcept { return sin_[i]; }
  // Index into LaserScan::ranges of used beam i.
  [[nodiscard]] std::size_t source(std::size_t i) const noexcept {
    return static_cast<std::size_t>(source_first_ + static_cast<std::ptrdiff_t>(i) * source_step_);
  }

 private:
  double angle_min_ = 0.0;
  double angle_increment_ = 0.0;
  std::size_t beams_ = 0;
  std::ptrdiff_t source_first_ = 0;
  std::ptrdiff_t source_step_ = 1;
  double first_ = 0.0;
  double step_ = 0.0;
  Buffer<double> cos_;
  Buffer<double> sin_;
};

// Valid returns as points in scan order (right to left). The car moves with `state` during the sweep.
// Invalid returns, the car's own body and what lies far behind are left out.
void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept;

}  // namespace firstlap
