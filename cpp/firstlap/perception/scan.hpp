// Step 1: beams to points in base_link at the end of the sweep.
#pragma once

#include <cstddef>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/params.hpp"

namespace firstlap {

inline constexpr std::size_t max_points = 2048;  // of one scan; denser scans are thinned evenly

struct ScanPoint {
  double x = 0.0;      // [m] base_link
  double y = 0.0;      // [m] base_link
  double range = 0.0;  // [m] from the laser
  int beam = 0;        // index among the beams used, right to left

  static constexpr auto columns() {
    using C = ScanPoint;
    return std::tuple{
        Column{"points",
               [](const C& p) {
                 return Point2{p.x, p.y};
               },
               "m", "valid returns, right to left"},
        Column{"point_range", &C::range, "m", "of each point from the laser"},
        Column{"point_beam", &C::beam, "", "of each point, counted from the right among the beams used"},
    };
  }
};

// Direction of the beams used, right to left, wherever the scan begins and whichever way it turns: the seam lies
// behind the car. Where the beams cross straight behind, the table has a slot for every beam of a full turn, and the
// slots that the laser does not cover are empty. Kept between scans of one shape.
class BeamTable {
 public:
  static constexpr std::ptrdiff_t no_source = -1;  // of an empty slot

  BeamTable();

  // Rebuilds the table where the scan's shape differs from the last one. False where the header makes
  // no sense: then nothing may be read.
  bool prepare(const LaserScan& scan) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return cos_.size(); }
  [[nodiscard]] double angle_step() const noexcept { return step_; }    // [rad] between used beams, > 0
  [[nodiscard]] double angle_first() const noexcept { return first_; }  // [rad] of the rightmost beam used
  // [rad] of used beam i, increasing. Two steps need not meet exactly where a full turn is closed.
  [[nodiscard]] double angle(std::size_t i) const noexcept {
    return i < seam_ ? first_ + step_ * static_cast<double>(i) : second_ + step_ * static_cast<double>(i - seam_);
  }
  [[nodiscard]] double cosine(std::size_t i) const noexcept { return cos_[i]; }
  [[nodiscard]] double sine(std::size_t i) const noexcept { return sin_[i]; }
  // Index into LaserScan::ranges of used beam i, or no_source.
  [[nodiscard]] std::ptrdiff_t source(std::size_t i) const noexcept { return source_[i]; }

 private:
  void lay_out(const LaserScan& scan) noexcept;
  void add(double angle, std::ptrdiff_t source) noexcept;

  double angle_min_ = 0.0;
  double angle_increment_ = 0.0;
  std::size_t beams_ = 0;
  double first_ = 0.0;
  double step_ = 0.0;
  double second_ = 0.0;   // [rad] of the slot `seam_`
  std::size_t seam_ = 0;  // the slot of the scan's own first beam; beyond the last where the scan is not turned
  Buffer<double> cos_;
  Buffer<double> sin_;
  Buffer<std::ptrdiff_t> source_;
};

// Valid returns as points in scan order (right to left). The car moves with `state` during the sweep.
// Invalid returns, the car's own body and what lies far behind are left out.
void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept;

}  // namespace firstlap
