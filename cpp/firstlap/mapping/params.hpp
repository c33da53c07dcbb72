// Parameters of mapping, with default, unit, range and meaning.
#pragma once

#include <string_view>
#include <tuple>
#include <type_traits>

#include "firstlap/common/field.hpp"

namespace firstlap::mapping {

// A scan as an evenly spaced cloud with normals.
struct CloudParams {
  double range_use = 20.0;
  double spacing = 0.06;
  double normal_reach = 0.2;
  double normal_noise = 0.02;
  double break_angle = 0.08;
  double break_max = 0.6;

  static constexpr auto fields() {
    using P = CloudParams;
    return std::tuple{
        Field{"range_use", &P::range_use, "m", 2.0, 60.0, "returns beyond this range are ignored"},
        Field{"spacing", &P::spacing, "m", 0.01, 0.5, "neighboring returns closer than this are averaged"},
        Field{"normal_reach", &P::normal_reach, "m", 0.02, 1.0, "normals are fitted over this distance to both sides"},
        Field{"normal_noise", &P::normal_noise, "m", 0.001, 0.2,
              "no normal where the points deviate more than this from a line"},
        Field{"break_angle", &P::break_angle, "rad", 0.02, 0.5,
              "smallest angle of incidence at which points belong to one wall"},
        Field{"break_max", &P::break_max, "m", 0.1, 3.0,
              "neighboring points farther apart than this never belong to one wall"},
    };
  }
};

// Point-to-line matching of a cloud with a reference.
struct MatchParams {
  int iterations = 20;
  double reach_first = 0.5;
  double reach_last = 0.1;
  double sigma = 0.015;
  double normal_angle = 0.6;
  double inlier_distance = 0.05;

  static constexpr auto fields() {
    using P = MatchParams;
    return std::tuple{
        Field{"iterations", &P::iterations, "", 1.0, 200.0, "maximum number of iterations"},
        Field{"reach_first", &P::reach_first, "m", 0.05, 3.0, "correspondence distance of the first iteration"},
        Field{"reach_last", &P::reach_last, "m", 0.02, 1.0, "correspondence distance of the last iteration"},
        Field{"sigma", &P::sigma, "m", 0.001, 0.2, "scale of the robust kernel: point-to-line distance"},
        Field{"normal_angle", &P::normal_angle, "rad", 0.1, 3.2,
              "maximum angle between the normals of a correspondence"},
        Field{"inlier_distance", &P::inlier_distance, "m", 0.005, 0.5, "maximum point-to-line distance of an inlier"},
    };
  }
};

// Pose graph: keyframes, edges and loop closures.
struct GraphParams {
  double keyframe_distance = 0.25;
  double keyframe_angle = 0.15;
  int submap_keyframes = 20;
  int edges = 4;
  double odometry_distance = 0.01;
  double odometry_angle = 0.02;
  double match_weight = 0.2;
  double loop_travel = 12.0;
  double loop_radius = 0.5;
  double loop_drift = 0.02;
  double loop_angle = 0.3;
  double loop_fit = 0.7;
  int loop_agree = 6;
  double loop_agree_distance = 0.15;
  double loop_agree_angle = 0.03;

  static constexpr auto fields() {
    using P = GraphParams;
    return std::tuple{
        Field{"keyframe_distance", &P::keyframe_distance, "m", 0.02, 5.0, "distance between keyframes"},
        Field{"keyframe_angle", &P::keyframe_angle, "rad", 0.02, 1.6, "rotation between keyframes"},
        Field{"submap_keyframes", &P::submap_keyframes, "", 1.0, 200.0,
              "number of keyframes a new scan is matched against"},
        Field{"edges", &P::edges, "", 1.0, 10.0, "pose-graph edges per keyframe, to those 1, 2, 4, 8, ... before it"},
        Field{"odometry_distance", &P::odometry_distance, "", 0.0005, 0.5, "longitudinal odometry error per meter"},
        Field{"odometry_angle", &P::odometry_angle, "rad", 0.0005, 0.5, "heading error of the odometry per meter"},
        Field{"match_weight", &P::match_weight, "", 0.001, 1.0, "independent measurements per matched point"},
        Field{"loop_travel", &P::loop_travel, "m", 2.0, 500.0, "minimum length of a loop"},
        Field{"loop_radius", &P::loop_radius, "m", 0.05, 10.0, "maximum distance between two poses of a loop closure"},
        Field{"loop_drift", &P::loop_drift, "", 0.0, 0.2,
              "growth of loop_radius per meter driven between the two poses"},
        Field{"loop_angle", &P::loop_angle, "rad", 0.02, 1.6, "maximum rotation between two poses of a loop closure"},
        Field{"loop_fit", &P::loop_fit, "", 0.1, 1.0, "share of points that must match for a loop closure"},
        Field{"loop_agree", &P::loop_agree, "", 1.0, 100.0, "consecutive scans that must agree on a loop closure"},
        Field{"loop_agree_distance", &P::loop_agree_distance, "m", 0.01, 2.0,
              "maximum position difference of scans that agree on a loop closure"},
        Field{"loop_agree_angle", &P::loop_agree_angle, "rad", 0.002, 0.5,
              "maximum heading difference of scans that agree on a loop closure"},
    };
  }
};

struct GridParams {
  double resolution = 0.025;
  double range_use = 12.0;
  double occupied_ratio = 0.2;
  int min_passes = 2;
  double margin = 0.5;

  static constexpr auto fields() {
    using P = GridParams;
    return std::tuple{
        Field{"resolution", &P::resolution, "m", 0.01, 0.2, "cell size of the map"},
        Field{"range_use", &P::range_use, "m", 1.0, 60.0, "returns beyond this range are ignored"},
        Field{"occupied_ratio", &P::occupied_ratio, "", 0.01, 1.0,
              "share of the beams meeting a cell that must end there for it to be occupied"},
        Field{"min_passes", &P::min_passes, "", 1.0, 100.0,
              "minimum number of beams that must meet a cell for it to be known"},
        Field{"margin", &P::margin, "m", 0.1, 10.0, "unknown margin around the map"},
    };
  }
};

// The mapping lap in the simulator.
struct DriveParams {
  double speed = 2.0;
  double overlap = 6.0;
  double give_up = 600.0;

  static constexpr auto fields() {
    using P = DriveParams;
    return std::tuple{
        Field{"speed", &P::speed, "m/s", 0.3, 10.0, "maximum speed of the mapping lap"},
        Field{"overlap", &P::overlap, "m", 0.0, 100.0, "distance driven after the loop closure"},
        Field{"give_up", &P::give_up, "m", 5.0, 100000.0, "distance without a loop closure after which mapping fails"},
    };
  }
};

struct MapParams {
  DriveParams drive{};
  CloudParams cloud{};
  MatchParams match{};
  GraphParams graph{};
  GridParams grid{};
};

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, MapParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("drive", params.drive);
  visit("cloud", params.cloud);
  visit("match", params.match);
  visit("graph", params.graph);
  visit("grid", params.grid);
}

// Throws std::invalid_argument: section, field, value, allowed range.
void validate(const MapParams& params);

}  // namespace firstlap::mapping
