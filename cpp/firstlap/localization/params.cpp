#include "firstlap/localization/params.hpp"

namespace firstlap::localization {

void validate(const LocalizerParams& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { firstlap::validate(section, name); });
  require_order(params.filter.particles_min, params.filter.particles_max, "filter.particles_min",
                "filter.particles_max");
  require_order(params.lost.fit_lost, params.lost.fit_search, "lost.fit_lost", "lost.fit_search");
}

}  // namespace firstlap::localization
