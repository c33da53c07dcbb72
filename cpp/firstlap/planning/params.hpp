// The parameters of planning, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
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
        Field{"spacing", &P::spacing, "m", 0.05, 0.5, "distance of centerline points and wall samples"},
        Field{"start_behind", &P::start_behind, "m", 0.0, 3.0, "the line starts this far behind the front axle"},
        Field{"horizon", &P::horizon, "m", 2.0, 20.0, "and ends this far ahead at most"},
        Field{"hold_time", &P::hold_time, "s", 0.0, 1.0, "how long the previous line serves when there is none"},
        Field{"memory_time", &P::memory_time, "s", 0.0, 3.0, "how long a wall that is out of sight is remembered"},
        Field{"trail_time", &P::trail_time, "s", 0.0, 20.0, "how long the car's own trail bars the way back"},
        Field{"trail_spacing", &P::trail_spacing, "m", 0.1, 1.0, "distance of the trail's points"},
        Field{"trail_against", &P::trail_against, "", -1.0, 0.0,
              "cosine of the angle to the trail below which the line runs back along it (-1: off)"},
        Field{"trail_free", &P::trail_free, "m", 0.0, 10.0,
              "so far from its beginning the line may run along the trail"},
        Field{"same_way", &P::same_way, "", 0.0, 1.0,
              "share of the track width within which the line is where the trail, or itself, has been"},
        Field{"turn_step", &P::turn_step, "rad", 0.05, 1.57, "the line turns by this at most from point to point"},
        Field{"loop_length", &P::loop_length, "m", 0.5, 30.0,
              "the line ends where it meets itself, so much of it later (30: off)"},
        Field{"sight_length", &P::sight_length, "m", 0.0, 10.0,
              "so far the line goes on between two visible ends without a wall (0: off, the track width)"},
        Field{"wall_step", &P::wall_step, "m", 0.0, 2.0,
              "wall samples nearer to each other are joined by a straight (0: off)"},
        Field{"end_slack", &P::end_slack, "", 0.0, 1.0,
              "sine of the angle past its end from where on a wall stands for nothing (1: off)"},
        Field{"seed_wall", &P::seed_wall, "", 0.0, 2.0,
              "no line begins behind a wall: nearest sample to the way there, in spacings (0: off)"},
        Field{"seed_reach", &P::seed_reach, "m", 0.0, 5.0,
              "where there is no line beside the front axle it may begin so far ahead (0: off)"},
        Field{"seed_step", &P::seed_step, "m", 0.1, 5.0, "between two tries to begin it; the last is so far behind"},
        Field{"clear_reach", &P::clear_reach, "m", 0.0, 20.0, "clearance counts so far ahead"},
        Field{"clear_enough", &P::clear_enough, "m", 0.01, 2.0, "beside the car, more clearance does not count"},
        Field{"clear_score_min", &P::clear_score_min, "", 0.0, 1.0, "score of a split with no clearance (1: off)"},
        Field{"turn_back_score", &P::turn_back_score, "", 0.0, 1.0, "score of a split whose line turns back (1: off)"},
        Field{"against_heading", &P::against_heading, "", -1.0, 0.0,
              "cosine below which the line passes the car backwards: the car was turned round (-1: off)"},
        Field{"line_enough", &P::line_enough, "m", 0.0, 10.0,
              "a longer line leaves no doubt: no other split is tried (0: none ever)"},
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

  static constexpr auto fields() {
    using P = TrajectoryParams;
    return std::tuple{
        Field{"smoothing_lambda", &P::smoothing_lambda, "", 0.0, 1.0,
              "Laplacian smoothing: step toward the neighbors' middle"},
        Field{"smoothing_iterations", &P::smoothing_iterations, "", 0.0, 200.0,
              "Laplacian smoothing: passes; more rounds corners off"},
        Field{"smoothing_margin", &P::smoothing_margin, "m", 0.0, 2.0,
              "smoothing brings the car's side no nearer than this to a wall"},
        Field{"smoothing_block", &P::smoothing_block, "", 0.0, 200.0,
              "smoothing passes between two looks at the walls (0: off, the walls are not looked at)"},
        Field{"opheim_min", &P::opheim_min, "m", 0.0, 0.5, "Opheim simplification: smallest tolerance (0: off)"},
        Field{"opheim_max", &P::opheim_max, "m", 0.0, 5.0, "Opheim simplification: longest step (0: off)"},
        Field{"sample", &P::sample, "m", 0.05, 0.5, "distance of trajectory points"},
        Field{"end_hold", &P::end_hold, "m", 0.0, 2.0,
              "the curvature is held over the last stretch, where the spline's end would straighten it"},
        Field{"join_distance", &P::join_distance, "m", 0.0, 10.0,
              "the trajectory leaves the car and joins the centerline over at least this (0: it is the centerline)"},
        Field{"join_time", &P::join_time, "s", 0.0, 3.0, "and at least over the way driven in this time"},
        Field{"join_angle", &P::join_angle, "rad", 0.0, 0.78, "a car further off the line's heading joins as at this"},
    };
  }
};

// Beyond the paper, whose path has no passes of these.
struct MinimumCurvatureParams {
  int bend_passes = 0;
  double bend_spacing = 1.0;
  double bend_lead = 0.33;
  double bend_sight = 4.0;
  double bend_radius = 1.2;

  static constexpr auto fields() {
    using P = MinimumCurvatureParams;
    return std::tuple{
        Field{"bend_passes", &P::bend_passes, "", 0.0, 200.0,
              "the path bends as little as the walls allow: relaxation passes (0: it is the smoothed centerline)"},
        Field{"bend_spacing", &P::bend_spacing, "m", 0.2, 3.0, "between the keys that are moved"},
        Field{"bend_lead", &P::bend_lead, "m", 0.0, 3.0,
              "so far from base_link the path follows the arc that is driven"},
        Field{"bend_sight", &P::bend_sight, "m", 0.1, 20.0, "over the last of the line the path comes back to it"},
        Field{"bend_radius", &P::bend_radius, "m", 0.0, 10.0, "no cutting where the line soon bends tighter than this"},
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
        Field{"v_min", &P::v_min, "m/s", 0.1, 10.0, "planned speed never falls below this (a stop stands outside)"},
        Field{"v_max", &P::v_max, "m/s", 0.1, 20.0, "planned speed never rises above this"},
        Field{"a_x_max", &P::a_x_max, "m/s^2", 0.1, 20.0, "planned acceleration"},
        Field{"a_x_min", &P::a_x_min, "m/s^2", -20.0, -0.1, "planned braking"},
        Field{"a_y_max", &P::a_y_max, "m/s^2", 0.1, 20.0, "planned lateral acceleration"},
        Field{"friction_ellipse", &P::friction_ellipse, "", 0.0, 1.0,
              "braking and accelerating share the grip with cornering"},
        Field{"preview_time", &P::preview_time, "s", 0.0, 1.0, "the commanded speed is the planned one this far ahead"},
        Field{"delta_v_max", &P::delta_v_max, "m/s", 0.0, 10.0,
              "commanded speed above the measured one at most (the paper's delta a_max)"},
        Field{"delta_v_min", &P::delta_v_min, "m/s", -10.0, 0.0,
              "commanded speed below the measured one at most (the paper's delta a_min)"},
        Field{"v_horizon", &P::v_horizon, "m/s", 0.0, 10.0, "speed at the end of what is seen"},
        Field{"v_standing", &P::v_standing, "m/s", 0.01, 2.0, "a slower car is planned for as if it drove this fast"},
        Field{"block_clearance", &P::block_clearance, "m", -0.5, 0.5,
              "the path is blocked where the car's side would come nearer than this to something"},
        Field{"block_distance", &P::block_distance, "m", 0.0, 2.0, "and the car stops this far before it"},
        Field{"a_brake", &P::a_brake, "m/s^2", 0.5, 20.0,
              "full braking, as a positive number, when nothing else helps"},
        Field{"stop_clearance", &P::stop_clearance, "m", 0.0, 0.5,
              "full braking where a stop begun a scan later would bring the body nearer than this to something"},
    };
  }
};

}  // namespace firstlap
