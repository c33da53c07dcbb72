// The scan period, needed to check a scan's time_increment.
#pragma once

#include "firstlap/common/plausible.hpp"

namespace firstlap {

// A slow low-pass filter: a single early or lost scan has little effect. Part of a driver's memory.
class ScanPeriod {
 public:
  // `dt`: [s] since the previous scan. Implausible values are ignored.
  void learn(double dt) noexcept {
    if (!(dt > 0.0 && dt <= max_pause)) return;
    seconds_ += (seconds_ > 0.0 ? newest_weight : 1.0) * (dt - seconds_);
  }
  [[nodiscard]] double seconds() const noexcept { return seconds_; }  // [s], 0: unknown

 private:
  static constexpr double newest_weight = 0.1;

  double seconds_ = 0.0;
};

}  // namespace firstlap
