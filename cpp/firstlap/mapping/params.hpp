// Every parameter of mapping, with its default, unit, range and meaning.
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
        Field{"range_use", &P::range_use, "m", 2.0, 60.0, "returns beyond this are not used"},
        Field{"spacing", &P::spacing, "m", 0.01, 0.5, "neighboring returns nearer than this become one, their mean"},
        Field{"normal_reach", &P::normal_reach, "m", 0.02, 1.0, "a normal is fitted over this to both sides"},
        Field{"normal_noise", &P::normal_noise, "m", 0.001, 0.2, "and is unknown where the points bend more than this"},
        Field{"break_angle", &P::break_angle, "rad", 0.02, 0.5, "smallest incidence that still is one wall"},
        Field{"break_max", &P::break_max, "m", 0.1, 3.0, "neighbors farther apart than this are never one wall"},
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
        Field{"iterations", &P::iterations, "", 1.0, 200.0, "at most"},
        Field{"reach_first", &P::reach_first, "m", 0.05, 3.0, "partners are sought this near at first"},
        Field{"reach_last", &P::reach_last, "m", 0.02, 1.0, "and this near at last"},
        Field{"sigma", &P::sigma, "m", 0.001, 0.2, "distance of a point from its line that is nothing unusual"},
        Field{"normal_angle", &P::normal_angle, "rad", 0.1, 3.2, "partners whose normals differ more are none"},
        Field{"inlier_distance", &P::inlier_distance, "m", 0.005, 0.5, "a point this near to its line fits"},
    };
  }
};

// The pose graph: which scans are kept, what is matched with what, when a loop is closed.
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
        Field{"keyframe_distance", &P::keyframe_distance, "m", 0.02, 5.0, "a scan is kept each time after this"},
        Field{"keyframe_angle", &P::keyframe_angle, "rad", 0.02, 1.6, "or after this turn"},
        Field{"submap_keyframes", &P::submap_keyframes, "", 1.0, 200.0, "a new scan is matched with so many"},
        Field{"edges", &P::edges, "", 1.0, 10.0,
              "each kept scan is tied to those 1, 2, 4, 8 ... before it, so many of them"},
        Field{"odometry_distance", &P::odometry_distance, "", 0.0005, 0.5, "error of odometry along, per meter"},
        Field{"odometry_angle", &P::odometry_angle, "rad", 0.0005, 0.5, "error of its heading, per meter"},
        Field{"match_weight", &P::match_weight, "", 0.001, 1.0,
              "a match counts as so many independent points per point"},
        Field{"loop_travel", &P::loop_travel, "m", 2.0, 500.0, "no loop is shorter than this"},
        Field{"loop_radius", &P::loop_radius, "m", 0.05, 10.0, "an earlier place is sought this near"},
        Field{"loop_drift", &P::loop_drift, "", 0.0, 0.2, "and this farther per meter driven since"},
        Field{"loop_angle", &P::loop_angle, "rad", 0.02, 1.6, "and turned by this at most"},
        Field{"loop_fit", &P::loop_fit, "", 0.1, 1.0, "share of points that must fit there"},
        Field{"loop_agree", &P::loop_agree, "", 1.0, 100.0, "so many scans in a row must say the same"},
        Field{"loop_agree_distance", &P::loop_agree_distance, "m", 0.01, 2.0, "to within this"},
        Field{"loop_agree_angle", &P::loop_agree_angle, "rad", 0.002, 0.5, "and this"},
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
        Field{"resolution", &P::resolution, "m", 0.01, 0.2, "side of a cell"},
        Field{"range_use", &P::range_use, "m", 1.0, 60.0, "returns beyond this draw nothing"},
        Field{"occupied_ratio", &P::occupied_ratio, "", 0.01, 1.0,
              "occupied where this share of the beams that met a cell ended there"},
        Field{"min_passes", &P::min_passes, "", 1.0, 100.0, "a cell that fewer beams met stays unknown"},
        Field{"margin", &P::margin, "m", 0.1, 10.0, "of unknown round the map"},
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
        Field{"speed", &P::speed, "m/s", 0.3, 10.0, "top speed of the mapping lap"},
        Field{"overlap", &P::overlap, "m", 0.0, 100.0, "driven on after the loop was seen to close"},
        Field{"give_up", &P::give_up, "m", 5.0, 100000.0, "driven without a loop: there is none"},
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
