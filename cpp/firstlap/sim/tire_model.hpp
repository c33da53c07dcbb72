// Tire forces of the single-track model: Pacejka's magic formula and the friction ellipse.
#pragma once

namespace firstlap::sim {

// Pacejka's B, C, D, E, without unit.
struct Tire {
  double b = 7.5;
  double c = 1.4;
  double d = 1.0;
  double e = 0.0;
};

// F_y / (mu F_z) = D sin(C atan(B a - E (B a - atan(B a)))) with the slip angle a [rad].
double magic_formula(const Tire& tire, double slip_angle) noexcept;

// Share of the lateral force that is left when the longitudinal force is `longitudinal` of at most `limit` [N].
double friction_ellipse(double longitudinal, double limit) noexcept;

}  // namespace firstlap::sim
