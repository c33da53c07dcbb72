// Parameters of perception, with default, unit, range and meaning. Names follow the paper and docs/paper.md.
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
        Field{"range_use", &P::range_use, "m", 2.0, 30.0, "returns beyond this range are ignored"},
        Field{"keep_behind", &P::keep_behind, "m", 0.0, 5.0, "points farther behind the front axle are dropped"},
        Field{"deskew", &P::deskew, "", 0.0, 1.0, "undo the car's motion during the sweep"},
        Field{"mask_angle", &P::mask_angle, "rad", 0.5, 3.15,
              "beams farther to the side than this may hit the car itself"},
        Field{"mask_range", &P::mask_range, "m", 0.0, 2.0,
              "beams beyond mask_angle are dropped if their range is below this"},
        Field{"footprint_margin", &P::footprint_margin, "m", 0.0, 0.3,
              "returns inside the car's body plus this margin are dropped"},
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
  double max_angle = 1.6;
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
  double end_step = 0.5;
  double end_beside = 0.3;
  double sight_step = 0.5;
  double sight_cos = 0.988;
  int end_samples = 3;
  int split_candidates = 3;
  double side_change_score = 0.6;

  static constexpr auto fields() {
    using P = SegmentationParams;
    return std::tuple{
        Field{"break_angle", &P::break_angle, "rad", 0.02, 0.5,
              "smallest angle of incidence at which a wall stays one section (lambda of Borges and Aldon)"},
        Field{"range_sigma", &P::range_sigma, "m", 0.0, 0.1, "range noise; the break test allows for three times this"},
        Field{"mean_gain", &P::mean_gain, "", 0.01, 1.0, "weight of the newest point distance in the weighted mean"},
        Field{"mean_factor", &P::mean_factor, "", 0.0, 20.0,
              "a point distance above this multiple of the weighted mean is a break (0: off)"},
        Field{"break_min", &P::break_min, "m", 0.01, 1.0, "minimum break threshold"},
        Field{"break_max", &P::break_max, "m", 0.1, 3.0, "maximum break threshold"},
        Field{"max_beam_gap", &P::max_beam_gap, "beams", 1.0, 100.0,
              "more consecutive lost beams than this are a break"},
        Field{"merge_distance", &P::merge_distance, "m", 0.0, 2.0, "neighboring sections closer than this are merged"},
        Field{"min_points", &P::min_points, "", 1.0, 50.0, "sections with fewer points are eliminated"},
        Field{"min_chord", &P::min_chord, "m", 0.0, 2.0, "sections with a shorter chord are eliminated"},
        Field{"max_nearest", &P::max_nearest, "m", 1.0, 30.0,
              "sections whose nearest point is farther away are eliminated"},
        Field{"max_angle", &P::max_angle, "rad", 0.1, 1.6,
              "sections whose chord is turned farther from the car's heading are eliminated (1.6: off)"},
        Field{"pass_ratio", &P::pass_ratio, "", 0.0, 1.0,
              "gaps narrower than this share of the track width are not passable"},
        Field{"pass_min", &P::pass_min, "m", 0.0, 2.0, "lower limit of the passable gap width"},
        Field{"pass_max", &P::pass_max, "m", 0.0, 4.0, "upper limit of the passable gap width"},
        Field{"one_sided_score", &P::one_sided_score, "", 0.0, 1.0,
              "score of all-left and all-right splits relative to a gap of the same depth"},
        Field{"past_weight", &P::past_weight, "", 0.0, 1.0, "weight of side consistency with earlier scans (0: off)"},
        Field{"past_radius", &P::past_radius, "m", 0.05, 1.0,
              "a wall point within this distance of an earlier one belongs to the same wall"},
        Field{"path_radius", &P::path_radius, "m", 0.0, 4.0,
              "wall points within this distance of the previous path keep their side of it"},
        Field{"chain_gap", &P::chain_gap, "m", 0.5, 20.0, "a side ends at a gap larger than this to its next section"},
        Field{"past_samples", &P::past_samples, "", 1.0, 1000.0,
              "number of labeled samples from which on side consistency has its full weight"},
        Field{"past_gain", &P::past_gain, "", 0.0, 10.0,
              "penalty of a split per share of labeled samples that contradict it"},
        Field{"past_same", &P::past_same, "m", 0.0, 1.0,
              "an earlier wall sample closer than this decides the label without a search of the other side"},
        Field{"seen_through", &P::seen_through, "", 0.0, 100.0,
              "maximum number of sections visible through one gap in a wall, which are then dropped (0: off)"},
        Field{"small_points", &P::small_points, "", 1.0, 2048.0,
              "an eliminated section with at least this many points keeps its previous side (2048: off)"},
        Field{"hole_score", &P::hole_score, "", 0.0, 1.0, "score of a hole in one wall relative to a gap (1: off)"},
        Field{"hole_stretch", &P::hole_stretch, "m", 0.05, 5.0,
              "length of wall over which the direction at the edges of a hole is measured"},
        Field{"hole_cos", &P::hole_cos, "", 0.0, 1.0,
              "minimum cosine between the direction at each edge and the line across the hole"},
        Field{"hole_beyond", &P::hole_beyond, "m", 0.0, 30.0,
              "a return this much farther away than the edges makes a hole a gap"},
        Field{"fit_share", &P::fit_share, "", 0.0, 2.0,
              "gaps narrower than this share of the track width score proportionally less (0: off)"},
        Field{"end_step", &P::end_step, "m", 0.0, 30.0,
              "a section that is this much farther away than the end of a wall beside the car need not be that wall "
              "(30: off)"},
        Field{"end_beside", &P::end_beside, "m", 0.0, 5.0,
              "a wall ends beside the car if its end is at most this far ahead of the LiDAR"},
        Field{"sight_step", &P::sight_step, "m", 0.0, 30.0,
              "past the end of a wall, the next beam bounds the occluded area if it is this much longer (30: off)"},
        Field{"sight_cos", &P::sight_cos, "", 0.0, 1.0,
              "minimum cosine of the angle between the end of a wall and the beam that bounds the occluded area"},
        Field{"end_samples", &P::end_samples, "", 1.0, 20.0,
              "number of wall samples over which the direction at a visible end is measured"},
        Field{"split_candidates", &P::split_candidates, "", 1.0, 3.0,
              "maximum number of splits that are tried (1: off)"},
        Field{"side_change_score", &P::side_change_score, "", 0.0, 1.0,
              "score factor of a split for each section that would change its side (1: off)"},
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
        Field{"width_initial", &P::width_initial, "m", 0.5, 6.0, "initial value of the remembered track width"},
        Field{"width_gain", &P::width_gain, "", 0.0, 1.0, "gain of a scan's median width in the remembered width"},
        Field{"width_min", &P::width_min, "m", 0.3, 3.0, "narrower wall pairs are ignored"},
        Field{"width_max", &P::width_max, "m", 1.0, 10.0,
              "wall pairs wider than this are not used: the nearer wall counts; if most pairs are wider, the width is "
              "this"},
        Field{"width_window", &P::width_window, "", 1.0, 25.0, "number of points in the moving average"},
        Field{"width_pairs", &P::width_pairs, "", 1.0, 100.0,
              "a scan with fewer wall pairs does not change the remembered width"},
        Field{"apex_width", &P::apex_width, "", 0.0, 1.0,
              "relative extra width assumed next to an apex that occludes the wall behind it"},
        Field{"bend_gain", &P::bend_gain, "", 0.0, 10.0,
              "gain of the extra width past a visible end, per sine of the angle at which the other wall curves across "
              "it (0: off)"},
        Field{"way_on_share", &P::way_on_share, "", 0.0, 1.0,
              "share of the free space past the visible end where the track continues that is added to the width (0: "
              "off)"},
        Field{"width_blend", &P::width_blend, "m", 0.1, 20.0,
              "distance beyond the last wall pair over which the width blends into the remembered one"},
    };
  }
};

}  // namespace firstlap
