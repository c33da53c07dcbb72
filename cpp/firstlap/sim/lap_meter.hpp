// Accumulates the statistics of the current lap.
#pragma once

#include <limits>

#include "firstlap/sim/race_result.hpp"

namespace firstlap::sim {

class LapMeter {
 public:
  // Adds the part of a physics step that belongs to this lap: dt [s], distance [m], speed [m/s], lateral offset [m].
  void add(double dt, double distance, double speed, double offset) noexcept;
  void add_clearance(double clearance) noexcept;                    // [m]
  double min_clearance() const noexcept { return min_clearance_; }  // [m] so far, +inf at the start
  double time() const noexcept { return time_; }                    // [s] so far

  // Ends the lap and starts an empty one.
  Lap finish(bool standing) noexcept;

 private:
  double time_ = 0.0, distance_ = 0.0, max_speed_ = 0.0, offset_squared_ = 0.0;
  double min_clearance_ = std::numeric_limits<double>::infinity();
};

}  // namespace firstlap::sim
