// Parameters of control, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
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
        Field{"k_soft", &P::k_soft, "m/s", 0.01, 50.0, "softening of the cross-track term at low speed"},
        Field{"k_damp", &P::k_damp, "", 0.0, 50.0, "damping of the cross-track term with speed"},
        Field{"k_rate", &P::k_rate, "s", -0.5, 0.5, "gain of the yaw-rate term"},
        Field{"k_steer", &P::k_steer, "", -2.0, 2.0, "gain of the change of the steering angle (damps if negative)"},
        Field{"k_ag", &P::k_ag, "s^2/m", 0.0, 0.1,
              "steady-state yaw in a curve, per v^2 kappa (Hoffmann et al. 2007, eq. 8)"},
        Field{"l_max", &P::l_max, "m", 0.0, 5.0, "lookahead distance on a straight"},
        Field{"kappa_n", &P::kappa_n, "1/m", 0.1, 100.0, "curvature that halves the lookahead"},
        Field{"rate_reference", &P::rate_reference, "", 0.0, 2.0,
              "reference yaw rate: 0 at the lookahead point, 1 at the nearest point, 2 none"},
        Field{"schedule_omega", &P::schedule_omega, "rad/s", 0.0, 30.0,
              "crossover frequency that the heading loop keeps by lowering k_ang with speed, with neutral lookahead "
              "(0: off)"},
    };
  }
};

// Beyond the paper: before every command, check that the car could still stop; brake if it could not.
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
              "minimum delay between command and start of braking; the car's own delays count if longer"},
        Field{"response_share", &P::response_share, "", 0.1, 1.0,
              "share of the nominal response of servo and speed loop that the check relies on"},
        Field{"grip_share", &P::grip_share, "", 1.0, 5.0,
              "lateral acceleration, relative to a_y_max, at which no grip is left for braking"},
        Field{"grip_left", &P::grip_left, "", 0.0, 1.0, "minimum square of the share of grip that is left for braking"},
        Field{"brake_bend_share", &P::brake_bend_share, "", 0.5, 5.0,
              "maximum lateral acceleration for which a braking car is steered, relative to a_y_max"},
        Field{
            "gentle_bend_share", &P::gentle_bend_share, "", 0.5, 5.0,
            "lateral acceleration, relative to a_y_max, above which the car brakes only as planned, to keep its grip"},
        Field{"release_share", &P::release_share, "", 0.1, 1.0,
              "full braking ends when a stop with this share of a_brake would be enough"},
        Field{"aim_distance", &P::aim_distance, "m", 0.0, 2.0,
              "lookahead distance of pure pursuit during a stop, from the front axle"},
        Field{"aim_time", &P::aim_time, "s", 0.0, 2.0, "additional lookahead during a stop, as travel time"},
        Field{"start_speed", &P::start_speed, "m/s", 0.1, 5.0,
              "minimum speed assumed by the check, since a stopped car is about to start"},
        Field{"blocked_distance", &P::blocked_distance, "m", 0.0, 5.0,
              "the car is blocked if it has to stop within this distance"},
        Field{"brake_slack", &P::brake_slack, "m^2/s^2", 0.0, 10.0,
              "full braking if planned braking would leave more than this squared speed at an obstacle"},
    };
  }
};

}  // namespace firstlap
