#include "firstlap/mapping/params.hpp"

namespace firstlap::mapping {

void validate(const MapParams& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  require_order(params.match.reach_last, params.match.reach_first, "match.reach_last", "match.reach_first");
}

}  // namespace firstlap::mapping
