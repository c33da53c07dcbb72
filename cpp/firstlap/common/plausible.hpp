// Plausibility of a measured state.
#pragma once

#include <cmath>

#include "firstlap/common/types.hpp"

namespace firstlap {

inline constexpr double max_pause = 0.5;  // [s] between scans; after a longer pause, earlier scans are discarded

// Whether the state is finite and possible for a car of this size. `dt` [s] is the time since the previous scan.
inline bool plausible(const VehicleState& state, double dt) noexcept {
  return std::isfinite(state.speed) && std::abs(state.speed) < 50.0 && std::isfinite(state.yaw_rate) &&
         std::abs(state.yaw_rate) < 50.0 && std::isfinite(state.steering_angle) &&
         std::abs(state.steering_angle) < 3.2 && std::isfinite(dt) && dt >= 0.0;
}

}  // namespace firstlap
