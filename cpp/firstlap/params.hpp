// Every parameter of the method, with its default, unit, range and meaning. A setup file holds what
// differs from these. Names follow the paper and docs/paper.md.
#pragma once

#include <tuple>
#include <utility>

#include "firstlap/car_geometry.hpp"
#include "firstlap/field.hpp"

namespace firstlap {

struct ScanParams {
  double range_use = 12.0;
  double keep_behind = 2.0;
  bool deskew = true;
  double mask_angle = 2.05;
  double mask_range = 0.8;
  double footprint_margin = 0.03;

  static constexpr auto fields() {
    using P = ScanParams;
    return std::tuple{
        Field{"range_use", &P::range_use, "m", 2.0, 30.0, "returns beyond this are not used"},
        Field{"keep_behind", &P::keep_behind, "m", 0.0, 5.0, "points further behind the front axle are neglected"},
        Field{"deskew", &P::deskew, "", 0.0, 1.0, "undo the car's motion during the sweep"},
        Field{"mask_angle", &P::mask_angle, "rad", 0.5, 3.15,
              "beams further to the side than this may see the car itself"},
        Field{"mask_range", &P::mask_range, "m", 0.0, 2.0, "and are dropped when shorter than this"},
        Field{"footprint_margin", &P::footprint_margin, "m", 0.0, 0.3,
              "returns inside the car's body plus this are dropped"},
    };
  }
};

struct SegmentationParams {
  double break_angle = 0.105;
  double range_sigma = 0.010;
  double mean_gain = 0.3;
  double mean_factor = 4.0;
  double break_min = 0.12;
  double break_max = 0.6;
  int max_beam_gap = 6;
  double merge_distance = 0.35;
  int min_points = 6;
  double min_chord = 0.25;
  double max_nearest = 8.0;
  double pass_ratio = 0.45;
  double pass_min = 0.5;
  double pass_max = 1.0;
  double one_sided_score = 0.5;
  double past_weight = 0.9;
  double past_radius = 0.3;
  double path_radius = 1.6;
  double chain_gap = 5.0;

  static constexpr auto fields() {
    using P = SegmentationParams;
    return std::tuple{
        Field{"break_angle", &P::break_angle, "rad", 0.02, 0.5,
              "smallest incidence that still is one wall (Borges and Aldon's lambda)"},
        Field{"range_sigma", &P::range_sigma, "m", 0.0, 0.1, "range noise that the break test allows for, three times"},
        Field{"mean_gain", &P::mean_gain, "", 0.01, 1.0, "weight of the newest distance in the weighted mean"},
        Field{"mean_factor", &P::mean_factor, "", 1.0, 20.0, "a distance above this many means is a break"},
        Field{"break_min", &P::break_min, "m", 0.01, 1.0, "no break below this distance"},
        Field{"break_max", &P::break_max, "m", 0.1, 3.0, "always a break above this distance"},
        Field{"max_beam_gap", &P::max_beam_gap, "beams", 1.0, 100.0, "more lost beams in a row are a break"},
        Field{"merge_distance", &P::merge_distance, "m", 0.0, 2.0, "neighbouring sections closer than this are one"},
        Field{"min_points", &P::min_points, "", 1.0, 50.0, "shorter sections are eliminated"},
        Field{"min_chord", &P::min_chord, "m", 0.0, 2.0, "smaller sections are eliminated"},
        Field{"max_nearest", &P::max_nearest, "m", 1.0, 30.0, "sections that begin further away are eliminated"},
        Field{"pass_ratio", &P::pass_ratio, "", 0.0, 1.0,
              "a gap below this share of the track width is no way through"},
        Field{"pass_min", &P::pass_min, "m", 0.0, 2.0, "but never below this"},
        Field{"pass_max", &P::pass_max, "m", 0.0, 4.0, "nor above this"},
        Field{"one_sided_score", &P::one_sided_score, "", 0.0, 1.0,
              "score of all-left and all-right against a gap of the same depth"},
        Field{"past_weight", &P::past_weight, "", 0.0, 1.0,
              "how much labels that contradict the past cost (0: no memory)"},
        Field{"past_radius", &P::past_radius, "m", 0.05, 1.0,
              "a wall point this near to an earlier one is the same wall"},
        Field{"path_radius", &P::path_radius, "m", 0.0, 4.0,
              "wall points this near to the previous path keep its side"},
        Field{"chain_gap", &P::chain_gap, "m", 0.5, 20.0, "a side ends where its next section is further away"},
    };
  }
};

struct TrackWidthParams {
  double width_initial = 2.0;
  double width_gain = 0.05;
  double width_min = 0.7;
  double width_max = 4.0;
  int width_window = 5;
  double width_blend = 4.0;
  double apex_width = 0.25;

  static constexpr auto fields() {
    using P = TrackWidthParams;
    return std::tuple{
        Field{"width_initial", &P::width_initial, "m", 0.5, 6.0, "remembered track width before anything was seen"},
        Field{"width_gain", &P::width_gain, "", 0.0, 1.0, "share of a scan's median width that goes into the memory"},
        Field{"width_min", &P::width_min, "m", 0.3, 3.0, "narrower pairs are not the track"},
        Field{"width_max", &P::width_max, "m", 1.0, 10.0,
              "wider pairs are not the track: the nearer side counts, and where most are, this width"},
        Field{"width_window", &P::width_window, "", 1.0, 25.0, "points in the moving average"},
        Field{"apex_width", &P::apex_width, "", 0.0, 1.0,
              "share by which the track is taken to be wider just past an apex that hides its wall"},
        Field{"width_blend", &P::width_blend, "m", 0.1, 20.0,
              "beyond the last pair the width fades to the remembered one over this"},
    };
  }
};

struct CenterlineParams {
  double spacing = 0.15;
  double start_behind = 0.9;
  double horizon = 9.0;
  double hold_time = 0.2;
  double memory_time = 0.8;
  double trail_time = 4.0;

  static constexpr auto fields() {
    using P = CenterlineParams;
    return std::tuple{
        Field{"spacing", &P::spacing, "m", 0.05, 0.5, "distance of centerline points and wall samples"},
        Field{"start_behind", &P::start_behind, "m", 0.0, 3.0, "the line starts this far behind the front axle"},
        Field{"horizon", &P::horizon, "m", 2.0, 20.0, "and ends this far ahead at most"},
        Field{"hold_time", &P::hold_time, "s", 0.0, 1.0, "how long the previous line serves when there is none"},
        Field{"memory_time", &P::memory_time, "s", 0.0, 3.0, "how long a wall that is out of sight is remembered"},
        Field{"trail_time", &P::trail_time, "s", 0.0, 20.0, "how long the car's own trail bars the way back"},
    };
  }
};

struct TrajectoryParams {
  double smoothing_lambda = 0.5;
  int smoothing_iterations = 10;
  double smoothing_margin = 0.15;
  double opheim_min = 0.03;
  double opheim_max = 1.0;
  double sample = 0.1;
  double end_hold = 0.5;
  double join_distance = 1.0;
  double join_time = 0.5;

  static constexpr auto fields() {
    using P = TrajectoryParams;
    return std::tuple{
        Field{"smoothing_lambda", &P::smoothing_lambda, "", 0.0, 1.0,
              "Laplacian smoothing: step towards the neighbours' middle"},
        Field{"smoothing_iterations", &P::smoothing_iterations, "", 0.0, 200.0,
              "Laplacian smoothing: passes; more rounds corners off"},
        Field{"smoothing_margin", &P::smoothing_margin, "m", 0.0, 2.0,
              "smoothing brings the car's side no nearer than this to a wall"},
        Field{"opheim_min", &P::opheim_min, "m", 0.0, 0.5, "Opheim simplification: smallest tolerance (0: off)"},
        Field{"opheim_max", &P::opheim_max, "m", 0.0, 5.0, "Opheim simplification: longest step (0: off)"},
        Field{"sample", &P::sample, "m", 0.05, 0.5, "distance of trajectory points"},
        Field{"end_hold", &P::end_hold, "m", 0.0, 2.0,
              "the curvature is held over the last stretch, where the spline's end would straighten it"},
        Field{"join_distance", &P::join_distance, "m", 0.0, 10.0,
              "the trajectory leaves the car and joins the centerline over at least this (0: it is the centerline)"},
        Field{"join_time", &P::join_time, "s", 0.0, 3.0, "and at least over the way driven in this time"},
    };
  }
};

// Beyond the paper, whose path has no passes of these.
struct LeastCurvatureParams {
  int bend_passes = 0;
  double bend_spacing = 1.0;
  double bend_lead = 0.33;
  double bend_sight = 4.0;
  double bend_radius = 1.2;

  static constexpr auto fields() {
    using P = LeastCurvatureParams;
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

// Beyond the paper: a car whose speed constant is wrong.
struct SpeedScaleParams {
  double scale_limit = 0.25;
  double scale_tolerance = 0.02;
  double command_tolerance = 0.04;
  double scale_sigma = 0.03;
  double scale_drift = 0.01;
  double scale_time = 4.0;
  double response_time = 0.15;

  static constexpr auto fields() {
    using P = SpeedScaleParams;
    return std::tuple{
        Field{"scale_limit", &P::scale_limit, "", 0.0, 0.5,
              "speeds are corrected by at most this share where the walls contradict them (0: believed as measured)"},
        Field{"scale_tolerance", &P::scale_tolerance, "", 0.0, 0.2,
              "a measured speed that is wrong by less is not corrected"},
        Field{"command_tolerance", &P::command_tolerance, "", 0.0, 0.2, "nor commands that the car exceeds by less"},
        Field{"scale_sigma", &P::scale_sigma, "", 0.001, 0.5, "error of the scale that the walls of one scan tell"},
        Field{"scale_drift", &P::scale_drift, "1/sqrt(s)", 0.0, 0.5, "and how much the car's own changes"},
        Field{"scale_time", &P::scale_time, "s", 0.5, 60.0, "how long what the car made of its commands is remembered"},
        Field{"response_time", &P::response_time, "s", 0.0, 1.0, "the car's speed comes this much after its command"},
    };
  }
};

struct Params {
  CarGeometry car{};
  ScanParams scan{};
  SegmentationParams segmentation{};
  TrackWidthParams track_width{};
  CenterlineParams centerline{};
  TrajectoryParams trajectory{};
  LeastCurvatureParams least_curvature{};
  VelocityProfileParams velocity_profile{};
  StanleyParams stanley{};
  SpeedScaleParams speed_scale{};
};

// Calls `visit(name, section)` for every section, in the order of the method. Field names are unique
// over all sections.
template <class AnyParams, class Visitor>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("car", params.car);
  visit("scan", params.scan);
  visit("segmentation", params.segmentation);
  visit("track_width", params.track_width);
  visit("centerline", params.centerline);
  visit("trajectory", params.trajectory);
  visit("least_curvature", params.least_curvature);
  visit("velocity_profile", params.velocity_profile);
  visit("stanley", params.stanley);
  visit("speed_scale", params.speed_scale);
}

// Throws std::invalid_argument: section, field, value, allowed range; also for pairs that contradict
// each other (v_min above v_max and the like).
void validate(const Params& params);

}  // namespace firstlap
