#include "firstlap/drivers/racer_params.hpp"

namespace firstlap {

void validate(const Params& params) {
  for_each_section(params, [](std::string_view name, const auto& section) { validate(section, name); });
  const auto& v = params.velocity_profile;
  const auto& s = params.segmentation;
  const auto& w = params.track_width;
  require_order(v.v_min, v.v_max, "velocity_profile.v_min", "velocity_profile.v_max");
  require_order(s.break_min, s.break_max, "segmentation.break_min", "segmentation.break_max");
  require_order(s.pass_min, s.pass_max, "segmentation.pass_min", "segmentation.pass_max");
  require_order(w.width_min, w.width_max, "track_width.width_min", "track_width.width_max");
}

}  // namespace firstlap
