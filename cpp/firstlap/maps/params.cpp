#include "firstlap/maps/params.hpp"

namespace firstlap::maps {

void validate(const MapParams& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  require_order(params.match.reach_last, params.match.reach_first, "match.reach_last", "match.reach_first");
}

void validate(const LocaliserParams& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  require_order(params.filter.particles_min, params.filter.particles_max, "filter.particles_min",
                "filter.particles_max");
  require_order(params.lost.fit_lost, params.lost.fit_search, "lost.fit_lost", "lost.fit_search");
}

}  // namespace firstlap::maps
