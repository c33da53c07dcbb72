// firstlap._core: Python bindings of the C++ layers. Users import the package firstlap instead.
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
