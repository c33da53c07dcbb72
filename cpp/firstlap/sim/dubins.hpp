// Shortest paths of a car that only drives forward (Dubins, 1957): three pieces, each of them straight or at full lock.
#pragma once

#include <array>
#include <vector>

#include "firstlap/common/types.hpp"

namespace firstlap::sim {

struct Arc {
  double curvature = 0.0;  // [1/m] left positive
  double length = 0.0;     // [m]
};

using DubinsPath = std::array<Arc, 3>;

// The pose at the end of an arc.
Pose2 along(const Pose2& from, const Arc& arc) noexcept;

double length(const DubinsPath& path) noexcept;  // [m]

// Every path of the six words LSL, RSR, LSR, RSL, RLR and LRL from `from` to `to` with turning radius `radius` [m] > 0,
// shortest first: at most six. They are the candidates for the shortest path; among obstacles a longer one may be free.
std::vector<DubinsPath> dubins_paths(const Pose2& from, const Pose2& to, double radius);

}  // namespace firstlap::sim
