// One function per binding file, called by module.cpp.
#pragma once

#include <nanobind/nanobind.h>

namespace firstlap::bindings {

void bind_core(nanobind::module_& m);
void bind_scan(nanobind::module_& m);
void bind_drivers(nanobind::module_& m);
void bind_sim(nanobind::module_& m);
void bind_mapping(nanobind::module_& m);
void bind_localization(nanobind::module_& m);
void bind_bench(nanobind::module_& m);
void bind_replay(nanobind::module_& m);
void bind_world(nanobind::module_& m);
void bind_state_estimate(nanobind::module_& m);
void bind_result_tables(nanobind::module_& m);

}  // namespace firstlap::bindings
