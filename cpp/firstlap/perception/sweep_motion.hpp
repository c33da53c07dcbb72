// Motion of base_link during the sweep of a scan, for deskewing.
#pragma once

#include "firstlap/common/types.hpp"

namespace firstlap {

class SweepMotion {
 public:
  // `state`: constant during the sweep.
  SweepMotion(const LaserScan& scan, const VehicleState& state) noexcept
      : beam_time_(scan.time_increment), speed_(state.speed), yaw_rate_(state.yaw_rate) {}

  // Whether all beams are measured at the same time, so that no deskewing is needed.
  [[nodiscard]] bool none() const noexcept { return beam_time_ == 0.0; }

  // A point [m] measured `beams_before` beams before the end of the sweep, transformed into base_link at its end.
  [[nodiscard]] Point2 at_end(Point2 p, int beams_before) const noexcept {
    const double before = static_cast<double>(beams_before) * beam_time_;
    const double yaw = -yaw_rate_ * before;
    const double c = 1.0 - 0.5 * yaw * yaw;
    return {c * p.x - yaw * p.y - speed_ * before, yaw * p.x + c * p.y - 0.5 * yaw * speed_ * before};
  }

 private:
  double beam_time_;  // [s]
  double speed_;      // [m/s]
  double yaw_rate_;   // [rad/s]
};

}  // namespace firstlap
