#include "firstlap/sim/tire_model.hpp"

#include <algorithm>
#include <cmath>

namespace firstlap::sim {

double magic_formula(const Tire& tire, double slip_angle) noexcept {
  const double x = tire.b * slip_angle;
  const double bent = tire.e == 0.0 ? x : x - tire.e * (x - std::atan(x));
  return tire.d * std::sin(tire.c * std::atan(bent));
}

double friction_ellipse(double longitudinal, double limit) noexcept {
  if (!(limit > 0.0)) return 0.0;
  const double used = longitudinal / limit;
  return std::sqrt(std::max(0.0, 1.0 - used * used));
}

}  // namespace firstlap::sim
