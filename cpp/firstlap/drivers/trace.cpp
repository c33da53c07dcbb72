#include "firstlap/drivers/trace.hpp"

namespace firstlap {

void Trace::clear() noexcept {
  points.clear();
  sections.clear();
  samples.clear();
  candidates = {};
  split = 0;
  walls.left.clear();
  walls.right.clear();
  line.points.clear();
  line.nearest = 0;
  line.ahead = 0.0;
  line.end = LineEnd::none;
  smoothed.clear();
  simplified.clear();
  path.clear();
  nearest = 0;
  lookahead = {};
  steering = {};
  width = clearance = 0.0;
  speed_scale = command_scale = 1.0;
  result = {};
}

}  // namespace firstlap
