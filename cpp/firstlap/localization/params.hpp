// Parameters of localization, with default, unit, range and meaning.
#pragma once

#include <string_view>
#include <tuple>
#include <type_traits>

#include "firstlap/common/field.hpp"
#include "firstlap/estimation/params.hpp"
#include "firstlap/mapping/params.hpp"

namespace firstlap::localization {

// Motion model of the filter.
struct MotionParams {
  double speed_noise = 0.1;
  double speed_ratio = 0.05;
  double yaw_rate_noise = 0.1;
  double yaw_rate_ratio = 0.1;
  double lateral_ratio = 0.04;
  double slip = 0.013;

  static constexpr auto fields() {
    using P = MotionParams;
    return std::tuple{
        Field{"speed_noise", &P::speed_noise, "m/s", 0.0, 5.0, "standard deviation of the speed"},
        Field{"speed_ratio", &P::speed_ratio, "", 0.0, 1.0, "increase of the speed's standard deviation per m/s"},
        Field{"yaw_rate_noise", &P::yaw_rate_noise, "rad/s", 0.0, 5.0, "standard deviation of the yaw rate"},
        Field{"yaw_rate_ratio", &P::yaw_rate_ratio, "", 0.0, 1.0,
              "increase of the yaw rate's standard deviation per rad/s"},
        Field{"lateral_ratio", &P::lateral_ratio, "", 0.0, 1.0,
              "standard deviation of the lateral speed per m/s of forward speed"},
        Field{"slip", &P::slip, "s^2/m", 0.0, 0.1, "slip angle of the rear axle per lateral acceleration"},
    };
  }
};

struct FilterParams {
  int particles_min = 2000;
  int particles_max = 4000;
  int beams = 60;
  double sigma_hit = 0.08;
  double sigma_search = 0.3;
  double noise_floor = 0.05;
  double weight_power = 0.5;
  double start_radius = 2.2;
  double start_angle = 0.9;
  double explorers = 0.08;
  double explorer_radius = 0.7;
  double explorer_angle = 0.25;
  double search_radius = 2.2;
  double search_angle = 0.9;
  double cluster_radius = 0.5;
  double cluster_angle = 0.35;

  static constexpr auto fields() {
    using P = FilterParams;
    return std::tuple{
        Field{"particles_min", &P::particles_min, "", 50.0, 20000.0, "number of particles while tracking"},
        Field{"particles_max", &P::particles_max, "", 50.0, 20000.0, "number of particles while searching"},
        Field{"beams", &P::beams, "", 5.0, 400.0, "returns per scan used to weight the particles"},
        Field{"sigma_hit", &P::sigma_hit, "m", 0.01, 1.0, "standard deviation of a return's distance from the map"},
        Field{"sigma_search", &P::sigma_search, "m", 0.01, 2.0,
              "standard deviation of a return's distance from the map while searching"},
        Field{"noise_floor", &P::noise_floor, "", 0.0001, 1.0, "likelihood of a random return"},
        Field{"weight_power", &P::weight_power, "", 0.01, 1.0,
              "exponent of the likelihood, since beams are not independent"},
        Field{"start_radius", &P::start_radius, "m", 0.0, 10.0, "maximum position error of the start pose"},
        Field{"start_angle", &P::start_angle, "rad", 0.0, 3.2, "maximum heading error of the start pose"},
        Field{"explorers", &P::explorers, "", 0.0, 0.5, "share of particles that always explore the neighborhood"},
        Field{"explorer_radius", &P::explorer_radius, "m", 0.0, 5.0, "maximum distance of explorers from the estimate"},
        Field{"explorer_angle", &P::explorer_angle, "rad", 0.0, 3.2,
              "maximum heading difference of explorers from the estimate"},
        Field{"search_radius", &P::search_radius, "m", 0.0, 10.0, "search radius of a lost filter"},
        Field{"search_angle", &P::search_angle, "rad", 0.0, 3.2, "angular search range of a lost filter"},
        Field{"cluster_radius", &P::cluster_radius, "m", 0.05, 5.0,
              "particles within this distance of the best one form the estimate"},
        Field{"cluster_angle", &P::cluster_angle, "rad", 0.02, 3.2,
              "particles within this heading difference of the best one form the estimate"},
    };
  }
};

struct RefineParams {
  int iterations = 10;
  int points = 250;
  double sigma = 0.05;
  double reach = 0.4;
  double prior = 0.05;

  static constexpr auto fields() {
    using P = RefineParams;
    return std::tuple{
        Field{"iterations", &P::iterations, "", 0.0, 50.0,
              "maximum iterations of the scan-to-map matching from the particle mean (0: off)"},
        Field{"points", &P::points, "", 10.0, 1000.0, "number of scan points used for matching"},
        Field{"sigma", &P::sigma, "m", 0.005, 0.5, "scale of the robust kernel: distance of a point from the map"},
        Field{"reach", &P::reach, "m", 0.05, 2.0, "scan points farther than this from the map are ignored"},
        Field{"prior", &P::prior, "m", 0.001, 1.0, "standard deviation of the prior at the particle mean"},
    };
  }
};

struct LostParams {
  double fit_distance = 0.1;
  double fit_search = 0.8;
  double fit_tight = 0.06;
  double fit_drop = 0.07;
  double fit_lost = 0.75;
  double fit_time = 0.5;
  double jump = 0.5;
  double found_time = 0.1;
  double found_again_time = 0.5;
  double std_search = 0.4;
  double std_lost = 0.7;

  static constexpr auto fields() {
    using P = LostParams;
    return std::tuple{
        Field{"fit_distance", &P::fit_distance, "m", 0.02, 1.0, "a point within this distance of the map matches"},
        Field{"fit_search", &P::fit_search, "", 0.0, 1.0, "share of matching points below which the filter searches"},
        Field{"fit_tight", &P::fit_tight, "m", 0.01, 1.0, "a point within this distance matches tightly"},
        Field{"fit_drop", &P::fit_drop, "", 0.0, 1.0,
              "the filter also searches if the tight match is this far below its own average"},
        Field{"fit_lost", &P::fit_lost, "", 0.0, 1.0,
              "averaged share of matching points below which the filter is lost"},
        Field{"fit_time", &P::fit_time, "s", 0.01, 10.0, "time constant of the averages"},
        Field{"jump", &P::jump, "m", 0.05, 10.0, "a pose this far from the odometry's prediction is rejected"},
        Field{"found_time", &P::found_time, "s", 0.0, 5.0,
              "how long all checks must pass before the filter is localized"},
        Field{"found_again_time", &P::found_again_time, "s", 0.0, 5.0,
              "how long all checks must pass before a lost filter is localized again"},
        Field{"std_search", &P::std_search, "m", 0.01, 5.0, "particle spread above which the filter searches"},
        Field{"std_lost", &P::std_lost, "m", 0.01, 5.0, "particle spread above which the filter is lost"},
    };
  }
};

struct LocalizerParams {
  mapping::CloudParams cloud{.range_use = 30.0};
  MotionParams motion{};
  FilterParams filter{};
  RefineParams refine{};
  LostParams lost{};
  SpeedScaleParams speed_scale{};
};

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, LocalizerParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("cloud", params.cloud);
  visit("motion", params.motion);
  visit("filter", params.filter);
  visit("refine", params.refine);
  visit("lost", params.lost);
  visit("speed_scale", params.speed_scale);
}

// Throws std::invalid_argument: section, field, value, allowed range.
void validate(const LocalizerParams& params);

}  // namespace firstlap::localization
