// Limits of the steering command.
#pragma once

#include "firstlap/common/car_geometry.hpp"

namespace firstlap {

// [rad] The steering angle nearest to `wanted` [rad] that the servo can reach `dt` [s] after the command `before`
// [rad].
double limit_steering(double wanted, double before, double dt, const CarGeometry& car) noexcept;

}  // namespace firstlap
