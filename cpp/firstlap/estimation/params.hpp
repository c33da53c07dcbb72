// The parameters of estimation, with default, unit, range and meaning.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

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

}  // namespace firstlap
