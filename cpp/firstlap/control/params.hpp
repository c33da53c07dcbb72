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

// Beyond the paper: the check before every command that the car could still stop, and the braking where it could not.
struct StoppingCheckParams {
  double reaction_time = 0.05;
  double response_share = 0.75;
  double grip_share = 2.0;
  double grip_left = 0.2;
  double brake_bend_share = 1.3;
  double gentle_bend_share = 1.2;
  double release_share = 0.8;
  double aim_distance = 0.15;
  double aim_time = 0.15;
  double start_speed = 0.5;
  double blocked_distance = 0.3;
  double brake_slack = 0.3;

  static constexpr auto fields() {
    using P = StoppingCheckParams;
    return std::tuple{
        Field{"reaction_time", &P::reaction_time, "s", 0.0, 0.5,
              "a stop begins at least this long after its command, and not before the car's delays are over"},
        Field{"response_share", &P::response_share, "", 0.1, 1.0,
              "share of how quickly the car's servo and speed loop respond that a stop counts on"},
        Field{"grip_share", &P::grip_share, "", 1.0, 5.0,
              "lateral acceleration, per a_y_max, that would leave no grip for braking"},
        Field{"grip_left", &P::grip_left, "", 0.0, 1.0, "but this share of the grip, squared, is always left for it"},
        Field{"brake_bend_share", &P::brake_bend_share, "", 0.5, 5.0,
              "a braking car is steered for at most this lateral acceleration, per a_y_max"},
        Field{"gentle_bend_share", &P::gentle_bend_share, "", 0.5, 5.0,
              "above this one, per a_y_max, the car brakes only as planned: a bend takes its grip"},
        Field{"release_share", &P::release_share, "", 0.1, 1.0,
              "full braking goes on until a stop with this share of a_brake would do"},
        Field{"aim_distance", &P::aim_distance, "m", 0.0, 2.0,
              "on the way to a stop the car steers to the path this far ahead of its front axle"},
        Field{"aim_time", &P::aim_time, "s", 0.0, 2.0, "and further by the distance driven in this time"},
        Field{"start_speed", &P::start_speed, "m/s", 0.1, 5.0, "a car that stands is about to go at least this fast"},
        Field{"blocked_distance", &P::blocked_distance, "m", 0.0, 5.0,
              "the car counts as blocked where it has to stop within this distance"},
        Field{"brake_slack", &P::brake_slack, "m^2/s^2", 0.0, 10.0,
              "full braking where planned braking would leave more than this speed, squared, before an obstacle"},
    };
  }
};

}  // namespace firstlap
