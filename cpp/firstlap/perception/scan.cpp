#include "firstlap/perception/scan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/sweep_motion.hpp"

namespace firstlap {

namespace {

constexpr double pi = std::numbers::pi;
constexpr double turn = 2.0 * pi;
constexpr double seam_slack = 0.5;  // [beams] a beam this far past straight behind still counts as straight behind
constexpr double rounding = 1e-6;   // [rad] rounding of angles in single precision

// The angle wrapped to [-pi, pi).
double wrap_behind(double angle) noexcept {
  if (angle >= -pi - rounding && angle < pi) return angle;
  return angle - turn * std::floor((angle + pi) / turn);
}

}  // namespace

BeamTable::BeamTable() : cos_(max_points), sin_(max_points), source_(max_points) {}

bool BeamTable::prepare(const LaserScan& scan) noexcept {
  if (check_header(scan) != ScanFault::none) return false;
  const std::size_t n = scan.ranges.size();
  if (n == beams_ && scan.angle_min == angle_min_ && scan.angle_increment == angle_increment_) return true;
  angle_min_ = scan.angle_min;
  angle_increment_ = scan.angle_increment;
  beams_ = n;
  lay_out(scan);
  return true;
}

void BeamTable::add(double angle, std::ptrdiff_t source) noexcept {
  cos_.push(std::cos(angle));
  sin_.push(std::sin(angle));
  source_.push(source);
}

// Beams past straight behind come first, with their angle reduced by a full turn; then the slots without a beam; then
// the other beams.
void BeamTable::lay_out(const LaserScan& scan) noexcept {
  const auto last = static_cast<std::ptrdiff_t>(scan.ranges.size()) - 1;
  const double increment = std::abs(scan.angle_increment);
  const double span = increment * static_cast<double>(last);
  const bool clockwise = scan.angle_increment < 0.0;
  const double begin = wrap_behind(clockwise ? scan.angle_min - span : scan.angle_min);
  const bool crosses = begin + span > pi + seam_slack * increment;
  const double slots = crosses ? std::max(turn, span) / increment : static_cast<double>(last);
  const auto stride = static_cast<std::ptrdiff_t>(std::floor(slots / static_cast<double>(max_points))) + 1;
  step_ = increment * static_cast<double>(stride);
  const auto in_turn = static_cast<std::ptrdiff_t>(std::round(turn / step_));
  const std::ptrdiff_t used = last / stride + 1;
  const std::ptrdiff_t count = crosses ? std::min(used, in_turn) : used;
  const std::ptrdiff_t seam = static_cast<std::ptrdiff_t>(std::floor((pi - begin) / step_ + seam_slack)) + 1;
  const std::ptrdiff_t turned = std::clamp<std::ptrdiff_t>(seam, 0, count);
  const auto angle = [&](std::ptrdiff_t k) { return begin + step_ * static_cast<double>(k); };
  const auto source = [&](std::ptrdiff_t k) { return clockwise ? last - k * stride : k * stride; };
  cos_.clear();
  sin_.clear();
  source_.clear();
  for (std::ptrdiff_t k = turned; k < count; ++k) add(angle(k) - turn, source(k));
  for (std::ptrdiff_t k = count; k < in_turn && turned < count; ++k) add(angle(k) - turn, no_source);
  seam_ = size();
  for (std::ptrdiff_t k = 0; k < turned; ++k) add(angle(k), source(k));
  second_ = begin;
  first_ = seam_ > 0 ? angle(turned) - turn : begin;
}

void scan_to_points(const LaserScan& scan, const BeamTable& table, const VehicleState& state, const ScanParams& params,
                    const CarGeometry& car, Buffer<ScanPoint>& points) noexcept {
  points.clear();
  LaserScan timed = scan;
  if (!params.deskew) timed.time_increment = 0.0;
  const SweepMotion motion(timed, state);
  const Footprint body(car, params.footprint_margin);
  const double far = params.range_use;
  const double mask_range = params.mask_range;
  const double mask_cos = std::cos(params.mask_angle);
  const double x_min = car.wheelbase - params.keep_behind;
  const int beams = static_cast<int>(table.size());
  const auto last = static_cast<std::ptrdiff_t>(scan.ranges.size()) - 1;

  for (int i = 0; i < beams; ++i) {
    const auto beam = static_cast<std::size_t>(i);
    const std::ptrdiff_t source = table.source(beam);
    if (source == BeamTable::no_source) continue;
    const double r = static_cast<double>(scan.ranges[static_cast<std::size_t>(source)]);
    if (!(is_return(scan, r) && r < far)) continue;
    if (r < mask_range && table.cosine(beam) < mask_cos) continue;
    const Point2 measured{car.laser_x + r * table.cosine(beam), car.laser_y + r * table.sine(beam)};
    const Point2 p = motion.at_end(measured, static_cast<int>(last - source));
    if (p.x < x_min || body.covers(p)) continue;
    points.push({p.x, p.y, r, i});
  }
}

}  // namespace firstlap
