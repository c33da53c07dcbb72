// The simulated car, the race options and those of the lap search as sections of field tables.
#pragma once

#include <string_view>

#include "firstlap/sim/car.hpp"
#include "firstlap/sim/lap_search.hpp"
#include "firstlap/sim/race.hpp"

namespace firstlap::sim {

template <class AnyCar, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyCar>, Car>
void for_each_section(AnyCar& car, Visitor&& visit) {
  visit("geometry", car.geometry);
  visit("vehicle", car.vehicle);
  visit("sensors", car.sensors);
  visit("state_estimate", car.state_estimate);
  visit("lidar", car.lidar);
}

template <class AnyOptions, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyOptions>, RaceOptions>
void for_each_section(AnyOptions& options, Visitor&& visit) {
  visit("race", options);
}

template <class AnyOptions, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyOptions>, LapSearchOptions>
void for_each_section(AnyOptions& options, Visitor&& visit) {
  visit("lap_search", options);
}

inline void validate(const Car& car) {
  for_each_section(car, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  const Vehicle checks_the_axles(car.geometry, car.vehicle);
  const Walls nothing;
  const Lidar checks_the_beams(car.lidar, nothing);
}

inline void validate(const RaceOptions& options) { firstlap::validate(options, "race"); }
inline void validate(const LapSearchOptions& options) { firstlap::validate(options, "lap_search"); }

}  // namespace firstlap::sim
