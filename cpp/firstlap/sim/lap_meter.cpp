#include "firstlap/sim/lap_meter.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap::sim {

void LapMeter::add(double dt, double distance, double speed, double offset) noexcept {
  time_ += dt;
  distance_ += distance;
  max_speed_ = std::max(max_speed_, speed);
  offset_squared_ += dt * offset * offset;
}

void LapMeter::add_clearance(double clearance) noexcept { min_clearance_ = std::min(min_clearance_, clearance); }

Lap LapMeter::finish(bool standing) noexcept {
  const double time = std::max(time_, std::numeric_limits<double>::min());
  const Lap lap{time_,   distance_, distance_ / time, max_speed_, min_clearance_, std::sqrt(offset_squared_ / time),
                standing};
  *this = LapMeter{};
  return lap;
}

}  // namespace firstlap::sim
