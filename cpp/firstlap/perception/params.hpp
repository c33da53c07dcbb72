// The parameters of perception, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

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
  double past_samples = 20.0;
  double past_gain = 3.0;
  double past_same = 0.1;
  int seen_through = 10;
  int small_points = 3;
  double hole_score = 0.2;
  double hole_stretch = 0.5;
  double hole_cos = 0.8;
  double hole_beyond = 0.5;
  double fit_share = 0.7;
  double both_share = 0.3;
  double sight_step = 0.5;
  double sight_cos = 0.988;
  int end_samples = 3;
  int split_candidates = 3;
  double side_change_score = 0.6;

  static constexpr auto fields() {
    using P = SegmentationParams;
    return std::tuple{
        Field{"break_angle", &P::break_angle, "rad", 0.02, 0.5,
              "smallest incidence that still is one wall (Borges and Aldon's lambda)"},
        Field{"range_sigma", &P::range_sigma, "m", 0.0, 0.1, "range noise that the break test allows for, three times"},
        Field{"mean_gain", &P::mean_gain, "", 0.01, 1.0, "weight of the newest distance in the weighted mean"},
        Field{"mean_factor", &P::mean_factor, "", 0.0, 20.0, "a distance above this many means is a break (0: off)"},
        Field{"break_min", &P::break_min, "m", 0.01, 1.0, "no break below this distance"},
        Field{"break_max", &P::break_max, "m", 0.1, 3.0, "always a break above this distance"},
        Field{"max_beam_gap", &P::max_beam_gap, "beams", 1.0, 100.0, "more lost beams in a row are a break"},
        Field{"merge_distance", &P::merge_distance, "m", 0.0, 2.0, "neighboring sections closer than this are one"},
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
        Field{"past_samples", &P::past_samples, "", 1.0, 1000.0, "labels of so many samples count fully"},
        Field{"past_gain", &P::past_gain, "", 0.0, 10.0, "times the share of labels against a split is what it costs"},
        Field{"past_same", &P::past_same, "m", 0.0, 1.0, "a wall sample nearer than this settles a label at once"},
        Field{"seen_through", &P::seen_through, "", 0.0, 100.0,
              "sections that may show through one gap in a wall, and then are not track (0: off)"},
        Field{"small_points", &P::small_points, "", 1.0, 2048.0,
              "an eliminated section with so many points keeps the side that it had (2048: off)"},
        Field{"hole_score", &P::hole_score, "", 0.0, 1.0, "score of a hole in one wall against a gap (1: off)"},
        Field{"hole_stretch", &P::hole_stretch, "m", 0.05, 5.0, "the edges of a hole are directed as over this"},
        Field{"hole_cos", &P::hole_cos, "", 0.0, 1.0, "cosine within which they point at each other"},
        Field{"hole_beyond", &P::hole_beyond, "m", 0.0, 30.0, "what shows this far past the edges makes it a gap"},
        Field{"fit_share", &P::fit_share, "", 0.0, 2.0,
              "a gap narrower than this share of the track width scores less (0: off)"},
        Field{"both_share", &P::both_share, "", 0.0, 1.0,
              "one wall around the car, this share of it on the other side before, is a dead end (1: off)"},
        Field{"sight_step", &P::sight_step, "m", 0.0, 30.0,
              "past the end of a wall, the beam that goes on this far bounds what is hidden (30: off)"},
        Field{"sight_cos", &P::sight_cos, "", 0.0, 1.0,
              "cosine to the next beam below which it tells nothing of the wall's end"},
        Field{"end_samples", &P::end_samples, "", 1.0, 20.0,
              "wall samples over which the direction at an end is taken"},
        Field{"split_candidates", &P::split_candidates, "", 1.0, 3.0, "best splits that may be tried (1: off)"},
        Field{"side_change_score", &P::side_change_score, "", 0.0, 1.0,
              "score of a split for each section that changes its side (1: off)"},
    };
  }
};

struct TrackWidthParams {
  double width_initial = 2.0;
  double width_gain = 0.05;
  double width_min = 0.7;
  double width_max = 4.0;
  int width_window = 5;
  int width_pairs = 3;
  double width_blend = 4.0;
  double apex_width = 0.25;
  double bend_gain = 2.0;
  double way_on_share = 1.0;

  static constexpr auto fields() {
    using P = TrackWidthParams;
    return std::tuple{
        Field{"width_initial", &P::width_initial, "m", 0.5, 6.0, "remembered track width before anything was seen"},
        Field{"width_gain", &P::width_gain, "", 0.0, 1.0, "share of a scan's median width that goes into the memory"},
        Field{"width_min", &P::width_min, "m", 0.3, 3.0, "narrower pairs are not the track"},
        Field{"width_max", &P::width_max, "m", 1.0, 10.0,
              "wider pairs are not the track: the nearer side counts, and where most are, this width"},
        Field{"width_window", &P::width_window, "", 1.0, 25.0, "points in the moving average"},
        Field{"width_pairs", &P::width_pairs, "", 1.0, 100.0, "a scan with fewer pairs of walls teaches no width"},
        Field{"apex_width", &P::apex_width, "", 0.0, 1.0,
              "share by which the track is taken to be wider just past an apex that hides its wall"},
        Field{"bend_gain", &P::bend_gain, "", 0.0, 10.0,
              "how soon a wall that bends across the end of the other one makes the track wider there (0: off)"},
        Field{"way_on_share", &P::way_on_share, "", 0.0, 1.0,
              "share of what is in sight past an end by which the way on leads that makes the track wider (0: off)"},
        Field{"width_blend", &P::width_blend, "m", 0.1, 20.0,
              "beyond the last pair the width fades to the remembered one over this"},
    };
  }
};

}  // namespace firstlap
