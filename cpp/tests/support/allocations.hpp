// Counts calls of operator new on this thread while `counting` (see allocation_test.cpp).
#pragma once

namespace firstlap::scene {

extern thread_local bool counting;
extern thread_local long allocations;

}  // namespace firstlap::scene
