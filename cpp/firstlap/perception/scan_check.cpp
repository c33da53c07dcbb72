#include "firstlap/perception/scan_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace firstlap {
namespace {

using namespace scan_limits;

constexpr double turn = 2.0 * std::numbers::pi;

double last_beam(const LaserScan& scan) noexcept { return static_cast<double>(scan.ranges.size()) - 1.0; }

double sweep_time(const LaserScan& scan) noexcept { return scan.time_increment * last_beam(scan); }

double usable_sweep_time_of(const LaserScan& scan, double period) noexcept {
  return usable_sweep_time(scan.time_increment, scan.ranges.size(), period);
}

// Whether the sector covered by the beams comes within `ahead` of straight ahead.
bool looks_ahead(const LaserScan& scan) noexcept {
  const double end = scan.angle_min + scan.angle_increment * last_beam(scan);
  const double first = std::min(scan.angle_min, end);
  const double span = std::abs(end - scan.angle_min);
  // Counterclockwise angle from the first beam to the right edge of the sector ahead.
  const double to_ahead = std::remainder(-ahead - first, turn);
  const double from_first = to_ahead < 0.0 ? to_ahead + turn : to_ahead;
  return from_first <= span || from_first + 2.0 * ahead >= turn;
}

bool angles_finite(const LaserScan& scan) noexcept {
  return std::isfinite(scan.angle_min) && std::isfinite(scan.angle_increment);
}

bool fits_angle_max(const LaserScan& scan, double angle_max) noexcept {
  if (std::isnan(angle_max)) return true;
  const double end = scan.angle_min + scan.angle_increment * last_beam(scan);
  return std::abs(angle_max - end) <= angle_max_slack * std::abs(scan.angle_increment);
}

template <class... Numbers>
std::string text(const char* format, Numbers... numbers) {
  char line[256];
  std::snprintf(line, sizeof line, format, numbers...);
  return line;
}

}  // namespace

double usable_sweep_time(double time_increment, std::size_t beams, double period) noexcept {
  const double sweep = time_increment * (static_cast<double>(beams) - 1.0);
  const double longest = period > 0.0 ? max_sweep_periods * period : max_sweep;
  return time_increment > 0.0 && beams > 1 && sweep <= longest ? sweep : 0.0;
}

ScanFault check_header(const LaserScan& scan, const ScanContext& context) noexcept {
  if (scan.ranges.size() < 2) return ScanFault::no_beams;
  const bool finite = angles_finite(scan) && std::isfinite(scan.time_increment) && std::isfinite(scan.range_min);
  if (!finite || std::isnan(scan.range_max) || std::isinf(context.angle_max)) return ScanFault::not_finite;
  if (std::abs(scan.angle_increment) < min_increment) return ScanFault::zero_increment;
  if (std::abs(scan.angle_min) > max_first_angle) return ScanFault::too_wide;
  if (std::abs(scan.angle_increment) * last_beam(scan) > max_span) return ScanFault::too_wide;
  if (!(scan.range_max > scan.range_min)) return ScanFault::range_limits;
  if (scan.time_increment < 0.0) return ScanFault::time_increment;
  if (!fits_angle_max(scan, context.angle_max)) return ScanFault::angle_max;
  return looks_ahead(scan) ? ScanFault::none : ScanFault::blind_ahead;
}

ScanCheck check_scan(const LaserScan& scan, const ScanContext& context) noexcept {
  ScanCheck check;
  check.beams = scan.ranges.size();
  check.fault = check_header(scan, context);
  if (!check.usable()) return check;
  check.time_usable = sweep_time(scan) == usable_sweep_time_of(scan, context.period);
  std::size_t in_reach = 0;
  for (const float range : scan.ranges) {
    const auto r = static_cast<double>(range);
    const bool returned = is_return(scan, r);
    check.returns += returned ? 1 : 0;
    in_reach += returned && r < reach ? 1 : 0;
  }
  if (in_reach >= min_returns) return check;
  const bool few = check.returns < min_returns;
  check.fault = few ? ScanFault::no_returns : ScanFault::nothing_in_reach;
  return check;
}

LaserScan with_usable_time(const LaserScan& scan, double period) noexcept {
  LaserScan usable = scan;
  if (usable_sweep_time_of(scan, period) == 0.0) usable.time_increment = 0.0;
  return usable;
}

const char* to_string(ScanFault fault) noexcept {
  switch (fault) {
    case ScanFault::none: return "none";
    case ScanFault::no_beams: return "no_beams";
    case ScanFault::not_finite: return "not_finite";
    case ScanFault::zero_increment: return "zero_increment";
    case ScanFault::too_wide: return "too_wide";
    case ScanFault::range_limits: return "range_limits";
    case ScanFault::time_increment: return "time_increment";
    case ScanFault::angle_max: return "angle_max";
    case ScanFault::blind_ahead: return "blind_ahead";
    case ScanFault::no_returns: return "no_returns";
    case ScanFault::nothing_in_reach: return "nothing_in_reach";
  }
  return "unknown";
}

std::string describe_fault(const LaserScan& scan, const ScanContext& context, const ScanCheck& check) {
  const auto beams = static_cast<int>(std::min<std::size_t>(check.beams, 1'000'000'000));
  switch (check.fault) {
    case ScanFault::none: return "";
    case ScanFault::no_beams: return text("%d beams; at least 2 are needed", beams);
    case ScanFault::not_finite:
      return text(
          "its header is not finite: angle_min %g, angle_increment %g, time_increment %g, range_min %g, "
          "range_max %g",
          scan.angle_min, scan.angle_increment, scan.time_increment, scan.range_min, scan.range_max);
    case ScanFault::zero_increment: return text("angle_increment is %g rad", scan.angle_increment);
    case ScanFault::too_wide:
      return text("%d beams from %g rad by %g rad are more than a full turn: are the angles in degrees?", beams,
                  scan.angle_min, scan.angle_increment);
    case ScanFault::range_limits:
      return text("range_max %g m is not above range_min %g m", scan.range_max, scan.range_min);
    case ScanFault::time_increment: return text("time_increment is %g s; it must be 0 or more", scan.time_increment);
    case ScanFault::angle_max:
      return text("%d beams from %g rad by %g rad do not end at angle_max %g rad", beams, scan.angle_min,
                  scan.angle_increment, context.angle_max);
    case ScanFault::blind_ahead:
      return text("no beam points ahead: %d beams from %.2f rad by %g rad, as mounted; is the laser's mounting right?",
                  beams, scan.angle_min, scan.angle_increment);
    case ScanFault::no_returns:
      return text("%d of %d beams return a range between range_min %g m and range_max %g m; at least %d are needed",
                  static_cast<int>(check.returns), beams, scan.range_min, scan.range_max,
                  static_cast<int>(min_returns));
    case ScanFault::nothing_in_reach:
      return text("nothing within %g m: are the ranges in millimeters or centimeters?", reach);
  }
  return "unknown";
}

std::string describe_time(const LaserScan& scan, const ScanContext& context, const ScanCheck& check) {
  if (check.time_usable) return "";
  const bool known = context.period > 0.0;
  return text(
      "time_increment makes the sweep last %.3g s, longer than the %s %.3g s%s: the car's motion during the "
      "sweep is not undone",
      sweep_time(scan), known ? "scan period of" : "longest plausible", known ? context.period : max_sweep,
      known ? "" : " (the scan period is not known)");
}

std::string describe_returns(const ScanCheck& check) {
  const double share = static_cast<double>(check.returns) / static_cast<double>(std::max<std::size_t>(check.beams, 1));
  return share < few_returns ? text("only %.0f %% of the beams return", 100.0 * share) : "";
}

}  // namespace firstlap
