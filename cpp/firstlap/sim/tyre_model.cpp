#include "firstlap/sim/tyre_model.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap::sim {

double magic_formula(const Tyre& tyre, double slip_angle) noexcept {
  const double x = tyre.b * slip_angle;
  const double bent = tyre.e == 0.0 ? x : x - tyre.e * (x - std::atan(x));
  return tyre.d * std::sin(tyre.c * std::atan(bent));
}

double friction_ellipse(double longitudinal, double limit) noexcept {
  if (!(limit > 0.0)) return 0.0;
  const double used = longitudinal / limit;
  return std::sqrt(std::max(0.0, 1.0 - used * used));
}

}  // namespace firstlap::sim
