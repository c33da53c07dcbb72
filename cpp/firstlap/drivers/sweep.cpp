#include "firstlap/drivers/sweep.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/sweep_motion.hpp"

namespace firstlap::drivers {
namespace {

constexpr double lost = -1.0;

}  // namespace

bool Sweep::read(const LaserScan& scan, const VehicleState& state, const ScanPeriod& period, const SweepParams& params,
                 const CarGeometry& car) noexcept {
  points_.clear();
  ranges_.clear();
  if (!check_scan(scan).usable() || !table_.prepare(scan)) return false;
  take_returns(scan, SweepMotion(with_usable_time(scan, period.seconds()), state), params, car);
  const auto seen = ranges_.size() - static_cast<std::size_t>(std::count(ranges_.begin(), ranges_.end(), lost));
  if (seen < scan_limits::min_returns) return false;
  fill_lost(params);
  return true;
}

void Sweep::take_returns(const LaserScan& scan, const SweepMotion& motion, const SweepParams& params,
                         const CarGeometry& car) noexcept {
  ranges_.fill(table_.size(), lost);
  const Footprint body(car, params.footprint_margin);
  const auto last = static_cast<std::ptrdiff_t>(scan.ranges.size()) - 1;
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const std::ptrdiff_t source = table_.source(i);
    if (source == BeamTable::no_source) continue;
    const double r = static_cast<double>(scan.ranges[static_cast<std::size_t>(source)]);
    if (!is_return(scan, r)) continue;
    const Point2 measured{car.laser_x + r * table_.cosine(i), car.laser_y + r * table_.sine(i)};
    if (motion.none()) {
      take(measured, i, r, params, body);
      continue;
    }
    const Point2 p = motion.at_end(measured, static_cast<int>(last - source));
    const double x = p.x - car.laser_x, y = p.y - car.laser_y;
    take(p, beam_at(std::atan2(y, x)), norm(x, y), params, body);
  }
}

// Adds a return at `p` (base_link), `range` [m] from the LiDAR in the direction of `beam`, unless it is from the car's
// own body.
void Sweep::take(Point2 p, std::size_t beam, double range, const SweepParams& params, const Footprint& body) noexcept {
  if (body.covers(p)) return;
  const double used = std::min(range, params.range_use);
  if (ranges_[beam] == lost || used < ranges_[beam]) ranges_[beam] = used;
  if (range < params.range_use) points_.push(p);
}

void Sweep::fill_lost(const SweepParams& params) noexcept {
  const double open = std::min(params.lost_range, params.range_use);
  const auto longest = static_cast<std::size_t>(params.max_lost_beams);
  for (std::size_t first = 0; first < ranges_.size(); ++first) {
    if (ranges_[first] != lost) continue;
    std::size_t last = first;
    while (last + 1 < ranges_.size() && ranges_[last + 1] == lost) ++last;
    const double before = first > 0 ? ranges_[first - 1] : open;
    const double after = last + 1 < ranges_.size() ? ranges_[last + 1] : open;
    const double value = last - first < longest ? std::min(before, after) : open;
    std::fill(ranges_.begin() + first, ranges_.begin() + last + 1, value);
    first = last;
  }
}

std::size_t Sweep::beam_at(double angle) const noexcept {
  const double index = std::round((angle - table_.angle_first()) / table_.angle_step());
  return static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(ranges_.size() - 1)));
}

}  // namespace firstlap::drivers
