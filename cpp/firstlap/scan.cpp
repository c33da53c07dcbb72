#include "firstlap/scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firstlap {

BeamTable::BeamTable() : cos_(max_points), sin_(max_points) {}

std::size_t BeamTable::source(std::size_t i) const noexcept {
  const std::size_t index = i * stride_;
  return clockwise_ ? beams_ - 1 - index : index;
}

bool BeamTable::prepare(const LaserScan& scan) noexcept {
  const std::size_t n = scan.ranges.size();
  if (n == 0 || !std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment)) return false;
  if (scan.angle_increment == 0.0 || std::abs(scan.angle_min) > 4.0 * std::numbers::pi) return false;
  if (std::abs(scan.angle_increment) * static_cast<double>(n - 1) > 2.0 * std::numbers::pi + 0.1) return false;
  if (!std::isfinite(scan.range_min) || std::isnan(scan.range_max) || !(scan.range_max > scan.range_min)) return false;
  if (!std::isfinite(scan.time_increment) || scan.time_increment < 0.0) return false;
  if (n == beams_ && scan.angle_min == angle_min_ && scan.angle_increment == angle_increment_) return true;

  angle_min_ = scan.angle_min;
  angle_increment_ = scan.angle_increment;
  beams_ = n;
  stride_ = (n + max_points - 1) / max_points;
  clockwise_ = scan.angle_increment < 0.0;
  step_ = std::abs(scan.angle_increment) * static_cast<double>(stride_);
  first_ = clockwise_ ? scan.angle_min + scan.angle_increment * static_cast<double>(n - 1) : scan.angle_min;
  cos_.clear();
  sin_.clear();
  for (std::size_t i = 0; i * stride_ < n; ++i) {
    const double angle = first_ + step_ * static_cast<double>(i);
    cos_.push(std::cos(angle));
    sin_.push(std::sin(angle));
  }
  return true;
}

void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept {
  points.clear();
  const double far = std::min(scan.range_max, params.range_use);
  const double x_min = car.wheelbase - params.keep_behind;
  const double body_front = car.length - car.rear_overhang + params.footprint_margin;
  const double body_back = -car.rear_overhang - params.footprint_margin;
  const double body_side = 0.5 * car.width + params.footprint_margin;
  const double body_reach = car.length + car.width + std::abs(car.laser_x);  // no beam meets the body beyond it
  const double mask_cos = std::cos(params.mask_angle);
  const double beam_time = params.deskew ? scan.time_increment : 0.0;
  const std::size_t last = scan.ranges.size() - 1;

  for (std::size_t i = 0; i < table.size(); ++i) {
    const std::size_t source = table.source(i);
    const double r = static_cast<double>(scan.ranges[source]);
    if (!(r > scan.range_min && r < far)) continue;  // also NaN
    if (r < params.mask_range && table.cosine(i) < mask_cos) continue;
    double x = car.laser_x + r * table.cosine(i);
    double y = r * table.sine(i);
    if (beam_time > 0.0) {
      // Where base_link was when this beam was measured, seen from where it is at the end.
      const double before = std::min(static_cast<double>(last - source) * beam_time, 0.2);
      const double turn = -state.yaw_rate * before;
      const double c = 1.0 - 0.5 * turn * turn;
      const double px = c * x - turn * y - state.speed * before;
      const double py = turn * x + c * y - 0.5 * turn * state.speed * before;
      x = px;
      y = py;
    }
    if (x < x_min) continue;
    if (r < body_reach && x < body_front && x > body_back && std::abs(y) < body_side) continue;
    points.push({x, y, r, static_cast<int>(i)});
  }
}

}  // namespace firstlap
