// Validity of scans and of single ranges. All users share these checks: drivers, mapping and localization call them
// directly, the driving node, `preflight` and `replay` through the binding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "firstlap/common/types.hpp"

namespace firstlap {

// Reason why a scan must not be used.
enum class ScanFault : std::uint8_t {
  none,
  no_beams,          // fewer than two
  not_finite,        // an angle, a time or range_min
  zero_increment,    // all beams have practically the same direction
  too_wide,          // more than a full turn, or a first beam turns away: angles in degrees
  range_limits,      // range_max is not above range_min
  time_increment,    // negative
  angle_max,         // does not match the number of beams
  blind_ahead,       // no beam points ahead: wrong mounting, or an unusable LiDAR
  no_returns,        // hardly any beam returns
  nothing_in_reach,  // everything is far away: ranges in millimeters or centimeters
};

// Information about a scan that is not in its header.
struct ScanContext {
  double period = 0.0;                                          // [s] between scans; 0: unknown
  double angle_max = std::numeric_limits<double>::quiet_NaN();  // [rad] as in the message; NaN: unknown
};

struct ScanCheck {
  ScanFault fault = ScanFault::none;
  bool time_usable = true;  // time_increment is consistent with the period, so the scan can be deskewed
  std::size_t beams = 0;
  std::size_t returns = 0;

  [[nodiscard]] bool usable() const noexcept { return fault == ScanFault::none; }
};

namespace scan_limits {
inline constexpr double range_max_margin = 0.05;  // [m] a range this close to range_max is no return
inline constexpr double max_first_angle = 13.0;   // [rad] two turns plus some mounting angle
inline constexpr double min_increment = 1e-6;     // [rad] between beams
inline constexpr double max_span = 6.4;           // [rad] a full turn plus one or two overlapping beams
inline constexpr double ahead = 0.5;              // [rad] to either side; at least one beam must point there
inline constexpr std::size_t min_returns = 4;
inline constexpr double reach = 10.0;              // [m] within which that many returns are required
inline constexpr double max_sweep_periods = 1.25;  // maximum sweep time in scan periods
inline constexpr double max_sweep = 0.5;           // [s] if the period is unknown
inline constexpr double angle_max_slack = 2.0;     // [beams]
inline constexpr double few_returns = 0.3;         // share of beams below which a remark is made
}  // namespace scan_limits

// Whether a range [m] of this scan is a return. Everything else is "no return": NaN, infinite, 0, at or beyond a limit
// (REP 117), and ranges clipped at range_max before noise or rounding to float.
[[nodiscard]] inline bool is_return(const LaserScan& scan, double range) noexcept {
  return range > scan.range_min && range > 0.0 && range < scan.range_max - scan_limits::range_max_margin;
}

// Checks the header only.
ScanFault check_header(const LaserScan& scan, const ScanContext& context = {}) noexcept;

// Checks header and ranges. Reads every range once.
ScanCheck check_scan(const LaserScan& scan, const ScanContext& context = {}) noexcept;

// Time [s] from the first beam to the last; 0 if time_increment [s] is negative, not finite, or gives a longer sweep
// than `period` [s] allows (0: unknown).
double usable_sweep_time(double time_increment, std::size_t beams, double period) noexcept;

// The scan, with time_increment set to 0 if it gives a longer sweep than `period` [s] allows (0: unknown).
LaserScan with_usable_time(const LaserScan& scan, double period) noexcept;

const char* to_string(ScanFault fault) noexcept;

// Messages for users, with the numbers: what is wrong and what would be right; empty if nothing is wrong. They
// allocate.
std::string describe_fault(const LaserScan& scan, const ScanContext& context, const ScanCheck& check);
std::string describe_time(const LaserScan& scan, const ScanContext& context, const ScanCheck& check);
std::string describe_returns(const ScanCheck& check);

}  // namespace firstlap
