// How often scans come: what tells whether a scan's time_increment can be true.
#pragma once

#include "firstlap/common/plausible.hpp"

namespace firstlap {

// Learned slowly, so that one scan that came early, or after a lost one, does not matter. Part of what a driver
// remembers from scan to scan.
class ScanPeriod {
 public:
  // dt: [s] since the scan before; what is no time between two scans teaches nothing.
  void learn(double dt) noexcept {
    if (!(dt > 0.0 && dt <= longest_pause)) return;
    seconds_ += (seconds_ > 0.0 ? newest_weight : 1.0) * (dt - seconds_);
  }
  [[nodiscard]] double seconds() const noexcept { return seconds_; }  // [s], 0: not known

 private:
  static constexpr double newest_weight = 0.1;

  double seconds_ = 0.0;
};

}  // namespace firstlap
