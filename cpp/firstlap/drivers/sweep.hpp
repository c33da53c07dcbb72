// One scan for the reactive drivers: a range for every beam, right to left, and the returns as points in base_link,
// both deskewed to the end of the sweep.
#pragma once

#include <cstddef>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/scan.hpp"
#include "firstlap/perception/scan_period.hpp"
#include "firstlap/perception/sweep_motion.hpp"

namespace firstlap::drivers {

struct SweepParams {
  double range_use = 10.0;
  double lost_range = 10.0;
  int max_lost_beams = 25;
  double footprint_margin = 0.03;

  static constexpr auto fields() {
    using P = SweepParams;
    return std::tuple{
        Field{"range_use", &P::range_use, "m", 1.0, 30.0, "ranges are clipped to this"},
        Field{"lost_range", &P::lost_range, "m", 0.1, 30.0, "free range assumed where many consecutive beams are lost"},
        Field{"max_lost_beams", &P::max_lost_beams, "beams", 0.0, 200.0,
              "up to this many consecutive lost beams take the range of the nearer neighbor"},
        Field{"footprint_margin", &P::footprint_margin, "m", 0.0, 0.3,
              "returns inside the car's body plus this margin are from the car itself and dropped"},
    };
  }
};

class Sweep {
 public:
  Sweep() : ranges_(max_points), points_(max_points) {}

  // Returns false for an unusable scan: invalid header or hardly any return. The scan is deskewed with `state` if
  // time_increment is consistent with `period`.
  bool read(const LaserScan& scan, const VehicleState& state, const ScanPeriod& period, const SweepParams& params,
            const CarGeometry& car) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return ranges_.size(); }
  [[nodiscard]] double range(std::size_t i) const noexcept { return ranges_[i]; }  // [m], finite, > 0
  [[nodiscard]] double angle_step() const noexcept { return table_.angle_step(); }
  [[nodiscard]] double angle(std::size_t i) const noexcept { return table_.angle(i); }
  [[nodiscard]] double cosine(std::size_t i) const noexcept { return table_.cosine(i); }
  [[nodiscard]] double sine(std::size_t i) const noexcept { return table_.sine(i); }
  // Index of the beam nearest to `angle` [rad].
  [[nodiscard]] std::size_t beam_at(double angle) const noexcept;
  [[nodiscard]] const Buffer<double>& ranges() const noexcept { return ranges_; }
  [[nodiscard]] const Buffer<Point2>& points() const noexcept { return points_; }

 private:
  void take_returns(const LaserScan& scan, const SweepMotion& motion, const SweepParams& params,
                    const CarGeometry& car) noexcept;
  void take(Point2 p, std::size_t beam, double range, const SweepParams& params, const Footprint& body) noexcept;
  void fill_lost(const SweepParams& params) noexcept;

  BeamTable table_;
  Buffer<double> ranges_;
  Buffer<Point2> points_;
};

}  // namespace firstlap::drivers
