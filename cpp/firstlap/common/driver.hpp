// What the simulator, the replay of a recording and the car call: scan and state in, command out.
#pragma once

#include "firstlap/common/types.hpp"

namespace firstlap {

class Driver {
 public:
  virtual ~Driver() = default;

  // One scan, the state measured at its end, and the time since the previous scan [s]. Never throws,
  // prints, locks, waits or allocates; any input whatever gives a finite command within limits.
  virtual StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept = 0;

  // Forgets everything that was seen.
  virtual void reset() noexcept = 0;
};

}  // namespace firstlap
