// The simulator's random numbers.
#pragma once

#include "firstlap/random/rng.hpp"

namespace firstlap::sim {

using firstlap::Rng;

}  // namespace firstlap::sim
