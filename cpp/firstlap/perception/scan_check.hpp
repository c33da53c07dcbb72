// Which scans may be used, and which of their ranges are returns. The only judge of both: drivers, mapping and
// localization ask it here, the driving node, `preflight` and `replay` through its binding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "firstlap/common/types.hpp"

namespace firstlap {

// Why a scan must not be used.
enum class ScanFault : std::uint8_t {
  none,
  no_beams,          // fewer than two
  not_finite,        // an angle, a time or range_min
  zero_increment,    // all beams point the same way, or as good as
  too_wide,          // more than a full turn, or a first beam turns away: angles in degrees
  range_limits,      // range_max is not above range_min
  time_increment,    // negative
  angle_max,         // it does not belong to this many beams
  blind_ahead,       // no beam points ahead: the mounting is wrong, or the laser cannot be used
  no_returns,        // hardly a beam returns
  nothing_in_reach,  // everything is far away: ranges in millimeters or centimeters
};

// What the caller knows of a scan beyond its header.
struct ScanContext {
  double period = 0.0;                                          // [s] between scans; 0: not known
  double angle_max = std::numeric_limits<double>::quiet_NaN();  // [rad] as its message states it; NaN: not known
};

struct ScanJudgement {
  ScanFault fault = ScanFault::none;
  bool time_usable = true;  // time_increment fits the period, so that the motion during the sweep can be undone
  std::size_t beams = 0;
  std::size_t returns = 0;

  [[nodiscard]] bool usable() const noexcept { return fault == ScanFault::none; }
};

namespace scan_limits {
inline constexpr double range_max_margin = 0.05;  // [m] a range this near to range_max is no return
inline constexpr double most_first_angle = 13.0;  // [rad] two turns, and a bit for a mounting
inline constexpr double least_increment = 1e-6;   // [rad] between beams
inline constexpr double most_span = 6.4;          // [rad] a full turn and a beam or two that overlap
inline constexpr double ahead = 0.5;              // [rad] to either side, where some beam must point
inline constexpr std::size_t fewest_returns = 4;
inline constexpr double reach = 10.0;           // [m] within which so many returns must lie
inline constexpr double most_periods = 1.25;    // a sweep longer than this is none
inline constexpr double longest_sweep = 0.5;    // [s] where the period is not known
inline constexpr double angle_max_slack = 2.0;  // [beams]
inline constexpr double few_returns = 0.3;      // share of the beams below which it is worth a remark
}  // namespace scan_limits

// Whether a range [m] of this scan is a return. Everything else is "no return", however it is spelled: NaN, infinite,
// 0, at or beyond a limit (REP 117), and what is clipped at range_max before the noise is added or rounded to float.
[[nodiscard]] inline bool is_return(const LaserScan& scan, double range) noexcept {
  return range > scan.range_min && range > 0.0 && range < scan.range_max - scan_limits::range_max_margin;
}

// Of the header alone.
ScanFault judge_header(const LaserScan& scan, const ScanContext& context = {}) noexcept;

// Of header and ranges. Reads every range once.
ScanJudgement judge(const LaserScan& scan, const ScanContext& context = {}) noexcept;

// From the first beam to the last [s]; 0 where time_increment [s] is negative, not finite, or makes it longer than
// `period` [s] allows (0: not known).
double usable_sweep_time(double time_increment, std::size_t beams, double period) noexcept;

// The scan, all beams of one moment where time_increment makes its sweep longer than `period` [s] allows (0: not
// known).
LaserScan with_usable_time(const LaserScan& scan, double period) noexcept;

const char* to_string(ScanFault fault) noexcept;

// For people, with the numbers in it: what is wrong and what would be right; empty where nothing is. Allocates.
std::string explain_fault(const LaserScan& scan, const ScanContext& context, const ScanJudgement& judgement);
std::string explain_time(const LaserScan& scan, const ScanContext& context, const ScanJudgement& judgement);
std::string explain_returns(const ScanJudgement& judgement);

}  // namespace firstlap
