#include "firstlap/drivers/sweep.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap::drivers {
namespace {

constexpr std::size_t fewest_returns = 4;
constexpr double lost = -1.0;

}  // namespace

bool Sweep::read(const LaserScan& scan, const SweepParams& params, const CarGeometry& car) noexcept {
  ranges_.clear();
  points_.clear();
  if (!table_.prepare(scan)) return false;
  const double front = car.length - car.rear_overhang + params.footprint_margin;
  const double back = -car.rear_overhang - params.footprint_margin;
  const double side = 0.5 * car.width + params.footprint_margin;
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const double r = static_cast<double>(scan.ranges[table_.source(i)]);
    ranges_.push(lost);
    if (!(r > scan.range_min && r > 0.0 && r < scan.range_max && std::isfinite(r))) continue;
    const double x = car.laser_x + r * table_.cosine(i);
    const double y = r * table_.sine(i);
    if (x > back && x < front && std::abs(y) < side) continue;
    ranges_.back() = std::min(r, params.range_use);
    if (r < params.range_use) points_.push({x, y});
  }
  const auto seen = ranges_.size() - static_cast<std::size_t>(std::count(ranges_.begin(), ranges_.end(), lost));
  if (seen < fewest_returns) return false;
  fill_lost(params);
  return true;
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
