#include "firstlap/mapping/cloud.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/perception/scan_check.hpp"

namespace firstlap::mapping {
namespace {

// Mapping and localization use returns behind the car, too.
ScanParams all_round(double range_use) {
  ScanParams params;
  params.range_use = range_use;
  params.keep_behind = range_use + 1.0;
  return params;
}

// Covariance [m^2] of points in the plane.
struct Spread {
  double xx = 0.0, xy = 0.0, yy = 0.0;

  void add(double weight, double dx, double dy) noexcept {
    xx += weight * dx * dx;
    xy += weight * dx * dy;
    yy += weight * dy * dy;
  }
  [[nodiscard]] double half() const noexcept { return 0.5 * (xx - yy); }
  [[nodiscard]] double root() const noexcept { return norm(half(), xy); }
  [[nodiscard]] double smallest() const noexcept { return 0.5 * (xx + yy) - root(); }
  [[nodiscard]] double largest() const noexcept { return 0.5 * (xx + yy) + root(); }
  // [rad] Direction of the largest spread.
  [[nodiscard]] double along() const noexcept { return 0.5 * std::atan2(xy, half()); }
};

}  // namespace

CloudMaker::CloudMaker(const CloudParams& params, const CarGeometry& car)
    : params_(params),
      car_(car),
      scan_(all_round(params.range_use)),
      points_(max_points),
      groups_(max_points),
      cloud_(max_points) {}

bool CloudMaker::make(const LaserScan& scan, const VehicleState& state, double period) noexcept {
  points_.clear();
  groups_.clear();
  cloud_.clear();
  if (!table_.prepare(scan)) return false;
  scan_to_points(with_usable_time(scan, period), table_, state, scan_, car_, points_);
  group_points();
  for (std::size_t i = 0; i < groups_.size(); ++i) add_normal(i);
  return true;
}

// Whether two consecutive returns lie on one wall: adaptive breakpoint detection of Borges and Aldon (2004).
bool CloudMaker::joined(const ScanPoint& a, const ScanPoint& b) const noexcept {
  const double step = table_.angle_step() * (b.beam - a.beam);
  if (step >= params_.break_angle) return false;
  const double nearer = std::min(a.range, b.range);
  const double limit = nearer * std::sin(step) / std::sin(params_.break_angle - step) + 3.0 * params_.normal_noise;
  return norm(b.x - a.x, b.y - a.y) <= std::min(limit, params_.break_max);
}

void CloudMaker::group_points() noexcept {
  std::size_t i = 0;
  bool opens = true;
  while (i < points_.size()) {
    const ScanPoint& first = points_[i];
    double x = first.x, y = first.y;
    std::size_t next = i + 1;
    bool one_wall = false;
    for (; next < points_.size(); ++next) {
      one_wall = joined(points_[next - 1], points_[next]);
      if (!one_wall || norm(points_[next].x - first.x, points_[next].y - first.y) > params_.spacing) break;
      x += points_[next].x;
      y += points_[next].y;
    }
    const auto count = static_cast<double>(next - i);
    groups_.push({x / count, y / count, opens});
    opens = !one_wall;
    i = next;
  }
}

// Fits a normal to the neighbors on the same wall within reach: at least one on each side, or two on one side.
void CloudMaker::add_normal(std::size_t i) noexcept {
  const Group& here = groups_[i];
  const auto near = [&](std::size_t j) {
    return norm(groups_[j].x - here.x, groups_[j].y - here.y) <= params_.normal_reach;
  };
  std::size_t first = i, last = i;
  while (first > 0 && !groups_[first].opens && (first == i || near(first - 1))) --first;
  while (last + 1 < groups_.size() && !groups_[last + 1].opens && (last == i || near(last + 1))) ++last;
  CloudPoint point{here.x, here.y, 0.0, 0.0};
  if (last - first >= 2) fit_normal(first, last, point);
  cloud_.push(point);
}

// The direction of least spread; none if the points do not lie on a line.
bool CloudMaker::fit_normal(std::size_t first, std::size_t last, CloudPoint& point) const noexcept {
  double mx = 0.0, my = 0.0;
  const double scale = 1.0 / static_cast<double>(last - first + 1);
  for (std::size_t j = first; j <= last; ++j) {
    mx += scale * groups_[j].x;
    my += scale * groups_[j].y;
  }
  Spread spread;
  for (std::size_t j = first; j <= last; ++j) spread.add(scale, groups_[j].x - mx, groups_[j].y - my);
  const double thickness = spread.smallest();
  if (thickness > params_.normal_noise * params_.normal_noise || thickness > 0.05 * spread.largest()) return false;
  const double along = spread.along();
  double nx = -std::sin(along), ny = std::cos(along);
  if (nx * (car_.laser_x - point.x) + ny * (car_.laser_y - point.y) < 0.0) {
    nx = -nx;
    ny = -ny;
  }
  point.nx = nx;
  point.ny = ny;
  return true;
}

}  // namespace firstlap::mapping
