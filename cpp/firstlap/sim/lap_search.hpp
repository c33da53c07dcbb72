// Whether a car can drive laps of a track at all: a search over positions and headings without reverse, with the car's
// turning circle and its rectangle against the solid walls. Steering is instantaneous: a car slow enough can do that.
//
// A lap that is found is a proof: a path of arcs that closes on itself, clear of the walls. That none is found holds
// for the resolution of the search. Cells of position and heading are visited once each, coarse ones first; where the
// search gets no farther, it goes back and tries again with finer ones.
#pragma once

#include <cstdint>
#include <tuple>
#include <vector>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/race.hpp"

namespace firstlap::sim {

struct LapSearchOptions {
  double margin = 0.02;
  double cell = 0.1;
  int headings = 72;
  int refinements = 2;
  double window = 6.0;
  double wrong_way_distance = RaceOptions{}.wrong_way_distance;
  int max_states = 4000000;

  static constexpr auto fields() {
    using P = LapSearchOptions;
    return std::tuple{
        Field{"margin", &P::margin, "m", 0.0, 1.0, "added to the car's rectangle on every side"},
        Field{"cell", &P::cell, "m", 0.01, 0.5, "coarsest size of a cell; an arc of the search is two cells long"},
        Field{"headings", &P::headings, "", 8.0, 1440.0, "coarsest number of headings"},
        Field{"refinements", &P::refinements, "", 0.0, 5.0,
              "how often cells and headings are halved where the search gets no farther"},
        Field{"window", &P::window, "m", 0.5, 50.0, "distance along the track that a finer search starts before"},
        Field{"wrong_way_distance", &P::wrong_way_distance, "m", 0.1, 1000.0,
              "driving back this far from the best progress is given up"},
        Field{"max_states", &P::max_states, "", 1000.0, 100000000.0, "the search is undecided beyond"},
    };
  }
};

enum class LapVerdict : std::uint8_t { drivable, blocked, undecided };

constexpr const char* to_string(LapVerdict verdict) noexcept {
  switch (verdict) {
    case LapVerdict::drivable: return "drivable";
    case LapVerdict::blocked: return "blocked";
    case LapVerdict::undecided: return "undecided";
  }
  return "unknown";
}

struct LapSearchResult {
  LapVerdict verdict = LapVerdict::blocked;
  double traveled = 0.0;
  int states = 0;
  int lap_start = 0;
  std::vector<Pose2> path{};

  static constexpr auto columns() {
    using C = LapSearchResult;
    return std::tuple{
        Column{"verdict", &C::verdict, "", "`drivable`, `blocked`, or `undecided`: more states than allowed"},
        Column{"traveled", &C::traveled, "m", "farthest progress along the centerline, from the start"},
        Column{"states", &C::states, "", "number of states"},
        Column{"lap_start", &C::lap_start, "", "drivable: index in the path from which it is a closed lap"},
        Column{"path", &C::path, "", "poses of base_link: a closed lap with the way to it, or the way to the farthest"},
    };
  }
};

// Searches from the start pose of a race, in the direction of the centerline. Throws std::invalid_argument for an
// invalid option or track.
LapSearchResult search_lap(const Track& track, const CarGeometry& car, const LapSearchOptions& options = {});

}  // namespace firstlap::sim
