#include "firstlap/control/limits.hpp"

#include <algorithm>

namespace firstlap {

double limit_steering(double wanted, double before, double dt, const CarGeometry& car) noexcept {
  const double step = car.steering_rate * dt;
  return std::clamp(std::clamp(wanted, before - step, before + step), -car.steering_limit, car.steering_limit);
}

}  // namespace firstlap
