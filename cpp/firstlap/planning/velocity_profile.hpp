// Step 6: the velocity profile of the path under limits of lateral acceleration, acceleration and braking (the paper's
// equations 3 to 5).
#pragma once

#include <cstddef>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

// Writes `velocity` of every point. The car is at point `from` with `speed` [m/s].
void plan_velocity(double speed, std::size_t from, const VelocityProfileParams& params,
                   Buffer<TrajectoryPoint>& path) noexcept;

// Lowers the profile so that the car stops at arc length `s` [m]; here v_min does not apply.
void stop_before(double s, const VelocityProfileParams& params, Buffer<TrajectoryPoint>& path) noexcept;

// The speed [m/s] to command: the profile at the preview point, limited relative to the measured `speed` [m/s].
double command_speed(const Buffer<TrajectoryPoint>& path, std::size_t from, double speed,
                     const VelocityProfileParams& params) noexcept;

}  // namespace firstlap
