// Buffers of one step. They hold no state: a step gives the same result whatever they contain at its start.
#pragma once

#include "firstlap/common/buffer.hpp"
#include "firstlap/drivers/trace.hpp"
#include "firstlap/perception/scan.hpp"
#include "firstlap/planning/minimum_curvature.hpp"
#include "firstlap/planning/spline.hpp"

namespace firstlap {

struct RacerWorkspace {
  RacerWorkspace()
      : ranges(max_points), spline(max_line_points), widths(max_line_points), control_points(max_control_points) {}

  Trace step;                           // results of the stages so far, handed over at the end of the step
  BeamTable table;                      // for the scan's header, reused while that stays the same
  Buffer<float> ranges;                 // [m] per beam
  LocalWalls walls;                     // of the split being tried
  Centerline line;                      // of the split being tried
  Spline spline;                        // of the path
  Buffer<double> widths;                // [m] track widths in one scan
  Buffer<ControlPoint> control_points;  // of the minimum-curvature path
};

}  // namespace firstlap
