// Parameters of estimation, with default, unit, range and meaning.
#pragma once

#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

// Beyond the paper: scale error of the measured and commanded speeds.
struct SpeedScaleParams {
  double scale_limit = 0.25;
  double scale_tolerance = 0.02;
  double command_tolerance = 0.04;
  double scale_sigma = 0.03;
  double scale_drift = 0.01;
  double scale_time = 4.0;

  static constexpr auto fields() {
    using P = SpeedScaleParams;
    return std::tuple{
        Field{"scale_limit", &P::scale_limit, "", 0.0, 0.5, "maximum relative correction of speeds (0: off)"},
        Field{"scale_tolerance", &P::scale_tolerance, "", 0.0, 0.2,
              "smaller relative errors of the measured speed are not corrected"},
        Field{"command_tolerance", &P::command_tolerance, "", 0.0, 0.2,
              "smaller relative errors of the commanded speed are not corrected"},
        Field{"scale_sigma", &P::scale_sigma, "", 0.001, 0.5,
              "standard deviation of the scale from the walls of one scan"},
        Field{"scale_drift", &P::scale_drift, "1/sqrt(s)", 0.0, 0.5, "random walk of the scale"},
        Field{"scale_time", &P::scale_time, "s", 0.5, 60.0,
              "time constant of the comparison of commanded and measured speed"},
    };
  }
};

}  // namespace firstlap
