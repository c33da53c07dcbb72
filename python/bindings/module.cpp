// firstlap._core: the C++ layers as Python sees them. The package firstlap is what people should import.
#include "modules.hpp"

NB_MODULE(_core, m) {
  m.doc() = "The C++ core of firstlap.";
  m.attr("__version__") = FIRSTLAP_VERSION;
  firstlap::bindings::bind_scan(m);
  firstlap::bindings::bind_core(m);
  firstlap::bindings::bind_drivers(m);
  firstlap::bindings::bind_sim(m);
  firstlap::bindings::bind_mapping(m);
  firstlap::bindings::bind_localization(m);
  firstlap::bindings::bind_bench(m);
  firstlap::bindings::bind_replay(m);
  firstlap::bindings::bind_world(m);
  firstlap::bindings::bind_state_estimate(m);
  firstlap::bindings::bind_result_tables(m);
}
