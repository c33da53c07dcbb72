// Validation shared by the reactive drivers.
#pragma once

#include <string_view>

#include "firstlap/common/field.hpp"

namespace firstlap::drivers {

// Throws std::invalid_argument with section, field, value and allowed range; also if v_min is above v_max.
template <class Params>
void validate_driver(const Params& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  require_order(params.speed.v_min, params.speed.v_max, "speed.v_min", "speed.v_max");
}

}  // namespace firstlap::drivers
