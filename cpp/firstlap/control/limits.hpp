// What a car can be told.
#pragma once

#include "firstlap/common/car_geometry.hpp"

namespace firstlap {

// [rad] The angle nearest to `wanted` that the wheels can have `dt` [s] after they were told `before`.
double limit_steering(double wanted, double before, double dt, const CarGeometry& car) noexcept;

}  // namespace firstlap
