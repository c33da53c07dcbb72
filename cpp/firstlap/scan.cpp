#include "firstlap/scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firstlap {

namespace {

// How base_link moves during the sweep.
class Motion {
 public:
  Motion(const LaserScan& scan, const VehicleState& state, bool deskew) noexcept
      : beam_time_(deskew ? scan.time_increment : 0.0), speed_(state.speed), yaw_rate_(state.yaw_rate) {}

  // What was measured so many beams before the end of the sweep, seen from where base_link is at its end.
  [[nodiscard]] Point2 at_end(Point2 p, int beams_before) const noexcept {
    const double before = std::min(static_cast<double>(beams_before) * beam_time_, 0.2);
    const double turn = -yaw_rate_ * before;
    const double c = 1.0 - 0.5 * turn * turn;
    return {c * p.x - turn * p.y - speed_ * before, turn * p.x + c * p.y - 0.5 * turn * speed_ * before};
  }

 private:
  double beam_time_;  // [s]
  double speed_;
  double yaw_rate_;
};

// The car's own body with its margin, in base_link.
class Body {
 public:
  Body(const ScanParams& params, const CarGeometry& car) noexcept
      : front_(car.length - car.rear_overhang + params.footprint_margin),
        back_(-car.rear_overhang - params.footprint_margin),
        side_(0.5 * car.width + params.footprint_margin),
        reach_(car.length + car.width + std::abs(car.laser_x)) {}

  [[nodiscard]] bool covers(Point2 p, double range) const noexcept {
    return range < reach_ && p.x < front_ && p.x > back_ && std::abs(p.y) < side_;
  }

 private:
  double front_;
  double back_;
  double side_;
  double reach_;  // [m] from the laser; no beam meets the body beyond it
};

}  // namespace

BeamTable::BeamTable() : cos_(max_points), sin_(max_points) {}

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
  const std::size_t stride = (n + max_points - 1) / max_points;
  const bool clockwise = scan.angle_increment < 0.0;
  source_first_ = clockwise ? static_cast<std::ptrdiff_t>(n) - 1 : 0;
  source_step_ = static_cast<std::ptrdiff_t>(stride) * (clockwise ? -1 : 1);
  step_ = std::abs(scan.angle_increment) * static_cast<double>(stride);
  first_ = clockwise ? scan.angle_min + scan.angle_increment * static_cast<double>(n - 1) : scan.angle_min;
  cos_.clear();
  sin_.clear();
  for (std::size_t i = 0; i * stride < n; ++i) {
    const double angle = first_ + step_ * static_cast<double>(i);
    cos_.push(std::cos(angle));
    sin_.push(std::sin(angle));
  }
  return true;
}

void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept {
  points.clear();
  const Motion motion(scan, state, params.deskew);
  const Body body(params, car);
  const double near = scan.range_min;
  const double far = std::min(scan.range_max, params.range_use);
  const double mask_range = params.mask_range;
  const double mask_cos = std::cos(params.mask_angle);
  const double laser_x = car.laser_x;
  const double x_min = car.wheelbase - params.keep_behind;
  const int beams = static_cast<int>(table.size());
  const int last = static_cast<int>(scan.ranges.size()) - 1;

  for (int i = 0; i < beams; ++i) {
    const auto beam = static_cast<std::size_t>(i);
    const std::size_t source = table.source(beam);
    const double r = static_cast<double>(scan.ranges[source]);
    if (!(r > near && r < far)) continue;  // also NaN
    if (r < mask_range && table.cosine(beam) < mask_cos) continue;
    const Point2 measured{laser_x + r * table.cosine(beam), r * table.sine(beam)};
    const Point2 p = motion.at_end(measured, last - static_cast<int>(source));
    if (p.x < x_min || body.covers(p, r)) continue;
    points.push({p.x, p.y, r, i});
  }
}

}  // namespace firstlap
