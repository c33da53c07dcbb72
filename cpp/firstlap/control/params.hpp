// The parameters of control, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

struct StanleyParams {
  double k_ang = 0.6;
  double k_dist = 0.5;
  double k_soft = 5.0;
  double k_damp = 1.0;
  double k_rate = -0.013;
  double k_steer = 0.0;
  double k_ag = 0.013;
  double l_max = 0.2;
  double kappa_n = 5.0;
  int rate_reference = 0;
  double schedule_omega = 0.0;

  static constexpr auto fields() {
    using P = StanleyParams;
    return std::tuple{
        Field{"k_ang", &P::k_ang, "", 0.0, 2.0, "gain of the heading error"},
        Field{"k_dist", &P::k_dist, "1/s", 0.0, 10.0, "gain of the cross-track error"},
        Field{"k_soft", &P::k_soft, "m/s", 0.01, 50.0, "softens the cross-track term at low speed"},
        Field{"k_damp", &P::k_damp, "", 0.0, 50.0, "softens the cross-track term with speed"},
        Field{"k_rate", &P::k_rate, "s", -0.5, 0.5, "gain of the yaw-rate term"},
        Field{"k_steer", &P::k_steer, "", -2.0, 2.0, "gain of the change of the wheel angle (damps when negative)"},
        Field{"k_ag", &P::k_ag, "s^2/m", 0.0, 0.1,
              "steady-state yaw of the car in a curve, per v^2 kappa (Hoffmann eq. 8)"},
        Field{"l_max", &P::l_max, "m", 0.0, 5.0, "lookahead on a straight"},
        Field{"kappa_n", &P::kappa_n, "1/m", 0.1, 100.0, "curvature that halves the lookahead"},
        Field{"rate_reference", &P::rate_reference, "", 0.0, 2.0,
              "yaw rate that counts as right: 0 lookahead point, 1 nearest point, 2 none"},
        Field{"schedule_omega", &P::schedule_omega, "rad/s", 0.0, 30.0,
              "k_ang falls with speed so that the heading loop keeps this crossover, lookahead neutral (0: off)"},
    };
  }
};

}  // namespace firstlap
