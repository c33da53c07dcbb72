// The interface of all drivers, called by the simulator, by replays and on the car: scan and state in, command out.
#pragma once

#include "firstlap/common/types.hpp"

namespace firstlap {

class Driver {
 public:
  virtual ~Driver() = default;

  // `state` is measured at the end of the scan; `dt` [s] is the time since the previous scan. Never throws, prints,
  // locks, waits or allocates. Any input gives a finite command within the car's limits.
  virtual StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept = 0;

  // Clears the memory of all earlier scans.
  virtual void reset() noexcept = 0;
};

}  // namespace firstlap
