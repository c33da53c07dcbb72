// Parameters of planning, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

struct CenterlineParams {
  double spacing = 0.15;
  double start_behind = 0.9;
  double horizon = 9.0;
  double hold_time = 0.2;
  double memory_time = 0.8;
  double trail_time = 4.0;
  double trail_spacing = 0.2;
  double trail_against = -0.5;
  double trail_free = 1.0;
  double same_way = 0.3;
  double turn_step = 0.6;
  double loop_length = 2.0;
  double sight_length = 4.0;
  double wall_step = 0.5;
  double end_slack = 0.1;
  double seed_wall = 0.6;
  double seed_reach = 2.0;
  double seed_step = 0.5;
  double clear_reach = 5.0;
  double clear_enough = 0.2;
  double clear_score_min = 0.3;
  double turn_back_score = 0.3;
  double against_heading = -0.3;
  double line_enough = 2.5;

  static constexpr auto fields() {
    using P = CenterlineParams;
    return std::tuple{
        Field{"spacing", &P::spacing, "m", 0.05, 0.5, "spacing of centerline points and wall samples"},
        Field{"start_behind", &P::start_behind, "m", 0.0, 3.0, "the centerline starts this far behind the front axle"},
        Field{"horizon", &P::horizon, "m", 2.0, 20.0, "maximum length of the centerline ahead of the front axle"},
        Field{"hold_time", &P::hold_time, "s", 0.0, 1.0, "how long the previous path is held if a scan gives none"},
        Field{"memory_time", &P::memory_time, "s", 0.0, 3.0, "how long occluded wall samples are carried over"},
        Field{"trail_time", &P::trail_time, "s", 0.0, 20.0,
              "how long trail points are kept; the centerline must not run back along them"},
        Field{"trail_spacing", &P::trail_spacing, "m", 0.1, 1.0, "spacing of trail points"},
        Field{"trail_against", &P::trail_against, "", -1.0, 0.0,
              "cosine of the angle to the trail below which the centerline runs back along it (-1: off)"},
        Field{"trail_free", &P::trail_free, "m", 0.0, 10.0,
              "length from its start over which the centerline may run back along the trail"},
        Field{"same_way", &P::same_way, "", 0.0, 1.0,
              "share of the track width within which the centerline meets the trail or itself"},
        Field{"turn_step", &P::turn_step, "rad", 0.05, 1.57,
              "maximum change of heading from one centerline point to the next"},
        Field{"loop_length", &P::loop_length, "m", 0.5, 30.0,
              "the centerline ends where it meets a point of itself that is at least this much arc length back (30: "
              "off)"},
        Field{"sight_length", &P::sight_length, "m", 0.0, 10.0,
              "maximum length without a wall between two visible ends, if longer than the track width (0: off)"},
        Field{"wall_step", &P::wall_step, "m", 0.0, 2.0,
              "wall samples closer than this are joined by a straight segment (0: off)"},
        Field{"end_slack", &P::end_slack, "", 0.0, 1.0,
              "sine of the angle past its visible end beyond which a wall no longer supports the centerline (1: off)"},
        Field{
            "seed_wall", &P::seed_wall, "", 0.0, 2.0,
            "minimum distance of the connection to the first centerline point from wall samples, in spacings (0: off)"},
        Field{"seed_reach", &P::seed_reach, "m", 0.0, 5.0,
              "maximum distance ahead of the front axle at which the centerline may start (0: off)"},
        Field{"seed_step", &P::seed_step, "m", 0.1, 5.0,
              "spacing of the start points that are tried; the last one is this far behind the front axle"},
        Field{"clear_reach", &P::clear_reach, "m", 0.0, 20.0,
              "length of centerline ahead over which the clearance of a split is scored"},
        Field{"clear_enough", &P::clear_enough, "m", 0.01, 2.0,
              "lateral clearance with which a split gets its full score"},
        Field{"clear_score_min", &P::clear_score_min, "", 0.0, 1.0,
              "score factor of a split without clearance (1: off)"},
        Field{"turn_back_score", &P::turn_back_score, "", 0.0, 1.0,
              "score factor of a split whose centerline turns back (1: off)"},
        Field{"against_heading", &P::against_heading, "", -1.0, 0.0,
              "cosine of centerline to car heading below which the car was turned around (-1: off)"},
        Field{"line_enough", &P::line_enough, "m", 0.0, 10.0,
              "a longer centerline is accepted without trying other splits (0: the first is always accepted)"},
    };
  }
};

struct TrajectoryParams {
  double smoothing_lambda = 0.5;
  int smoothing_iterations = 10;
  double smoothing_margin = 0.15;
  int smoothing_block = 10;
  double opheim_min = 0.03;
  double opheim_max = 1.0;
  double sample = 0.1;
  double end_hold = 0.5;
  double join_distance = 1.0;
  double join_time = 0.5;
  double join_angle = 0.78;
  bool join_previous = false;

  static constexpr auto fields() {
    using P = TrajectoryParams;
    return std::tuple{
        Field{"smoothing_lambda", &P::smoothing_lambda, "", 0.0, 1.0,
              "Laplacian smoothing: step toward the midpoint of the neighbors"},
        Field{"smoothing_iterations", &P::smoothing_iterations, "", 0.0, 200.0,
              "Laplacian smoothing: number of passes; more passes cut corners more"},
        Field{"smoothing_margin", &P::smoothing_margin, "m", 0.0, 2.0,
              "minimum distance between the car's side and a wall that smoothing keeps"},
        Field{"smoothing_block", &P::smoothing_block, "", 0.0, 200.0,
              "smoothing passes between two corrections of the distance to walls (0: off)"},
        Field{"opheim_min", &P::opheim_min, "m", 0.0, 0.5, "Opheim simplification: minimum tolerance (0: off)"},
        Field{"opheim_max", &P::opheim_max, "m", 0.0, 5.0, "Opheim simplification: maximum step length (0: off)"},
        Field{"sample", &P::sample, "m", 0.05, 0.5, "spacing of trajectory points"},
        Field{"end_hold", &P::end_hold, "m", 0.0, 2.0,
              "length at the end of the path over which the curvature is held constant (the spline's natural end would "
              "straighten it)"},
        Field{"join_distance", &P::join_distance, "m", 0.0, 10.0,
              "minimum distance over which the path joins the centerline (0: the path is the centerline)"},
        Field{"join_time", &P::join_time, "s", 0.0, 3.0,
              "minimum travel time over which the path joins the centerline"},
        Field{"join_angle", &P::join_angle, "rad", 0.0, 0.78,
              "limit of the heading error for which the joining curve is computed"},
        Field{"join_previous", &P::join_previous, "", 0.0, 1.0,
              "the path joins the centerline from the previous path instead of from the car"},
    };
  }
};

// Beyond the paper, whose path is the smoothed centerline (0 passes).
struct MinimumCurvatureParams {
  int bend_passes = 0;
  double bend_spacing = 1.0;
  double bend_lead = 0.33;
  double bend_sight = 4.0;

  static constexpr auto fields() {
    using P = MinimumCurvatureParams;
    return std::tuple{
        Field{"bend_passes", &P::bend_passes, "", 0.0, 200.0,
              "relaxation passes of the minimum-curvature path (0: smoothed centerline)"},
        Field{"bend_spacing", &P::bend_spacing, "m", 0.2, 3.0, "spacing of the control points"},
        Field{"bend_lead", &P::bend_lead, "m", 0.0, 3.0,
              "distance from base_link over which the path follows the current arc of the car"},
        Field{"bend_sight", &P::bend_sight, "m", 0.1, 20.0,
              "distance at the end of the centerline over which the path returns to it"},
    };
  }
};

struct VelocityProfileParams {
  double v_min = 2.0;
  double v_max = 4.0;
  double a_x_max = 5.0;
  double a_x_min = -4.5;
  double a_y_max = 2.3;
  bool friction_ellipse = false;
  double preview_time = 0.12;
  double delta_v_max = 0.5;
  double delta_v_min = -0.5;
  double v_horizon = 1.0;
  double v_standing = 0.3;
  double block_clearance = 0.05;
  double block_distance = 0.2;
  double a_brake = 5.0;
  double stop_clearance = 0.04;

  static constexpr auto fields() {
    using P = VelocityProfileParams;
    return std::tuple{
        Field{"v_min", &P::v_min, "m/s", 0.1, 10.0, "minimum planned speed (stops are exempt)"},
        Field{"v_max", &P::v_max, "m/s", 0.1, 20.0, "maximum planned speed"},
        Field{"a_x_max", &P::a_x_max, "m/s^2", 0.1, 20.0, "maximum planned acceleration"},
        Field{"a_x_min", &P::a_x_min, "m/s^2", -20.0, -0.1, "maximum planned deceleration, as a negative number"},
        Field{"a_y_max", &P::a_y_max, "m/s^2", 0.1, 20.0, "maximum planned lateral acceleration"},
        Field{"friction_ellipse", &P::friction_ellipse, "", 0.0, 1.0,
              "braking and acceleration share the grip with cornering"},
        Field{"preview_time", &P::preview_time, "s", 0.0, 1.0,
              "the commanded speed is the planned speed this far ahead"},
        Field{"delta_v_max", &P::delta_v_max, "m/s", 0.0, 10.0,
              "maximum of commanded minus measured speed (delta a_max in the paper)"},
        Field{"delta_v_min", &P::delta_v_min, "m/s", -10.0, 0.0,
              "minimum of commanded minus measured speed (delta a_min in the paper)"},
        Field{"v_horizon", &P::v_horizon, "m/s", 0.0, 10.0, "planned speed at the end of the visible track"},
        Field{"v_standing", &P::v_standing, "m/s", 0.01, 2.0, "minimum speed from which the profile is planned"},
        Field{"block_clearance", &P::block_clearance, "m", -0.5, 0.5,
              "the path is blocked where the car's side would come closer than this to a wall or obstacle"},
        Field{"block_distance", &P::block_distance, "m", 0.0, 2.0,
              "distance to a blocked point at which the car stops"},
        Field{"a_brake", &P::a_brake, "m/s^2", 0.5, 20.0, "deceleration of full braking, as a positive number"},
        Field{"stop_clearance", &P::stop_clearance, "m", 0.0, 0.5,
              "the stopping check brakes fully if a stop started one scan later would have less clearance than this"},
    };
  }
};

}  // namespace firstlap
