// Checks that the opponents' parameters share.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "firstlap/field.hpp"

namespace firstlap::drivers {

// Throws std::invalid_argument: section, field, value, allowed range; also where v_min is above v_max.
template <class Params>
void validate_driver(const Params& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  if (params.speed.v_min > params.speed.v_max) {
    throw std::invalid_argument("speed.v_min is " + std::to_string(params.speed.v_min) +
                                ", allowed at most speed.v_max, which is " + std::to_string(params.speed.v_max));
  }
}

}  // namespace firstlap::drivers
