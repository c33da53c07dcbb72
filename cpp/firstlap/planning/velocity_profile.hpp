// Step 6: the speed along the path, under three acceleration limits (the paper's equations 3 to 5).
#pragma once

#include <cstddef>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

// Fills `velocity` of every point; the car is at point `from` with `speed`.
void plan_velocity(double speed, std::size_t from, const VelocityProfileParams& params,
                   Buffer<TrajectoryPoint>& path) noexcept;

// Lowers the profile so that the car can stand still at arc length `s` [m]; outside the clamp to v_min.
void stop_before(double s, const VelocityProfileParams& params, Buffer<TrajectoryPoint>& path) noexcept;

// The speed to command: the planned one at the preview point, limited in its change.
double command_speed(const Buffer<TrajectoryPoint>& path, std::size_t from, double speed,
                     const VelocityProfileParams& params) noexcept;

}  // namespace firstlap
