// The buffers of one step. They hold nothing between steps: whatever stands in them when a step begins, it does the
// same.
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

  Trace step;             // the results of the stages so far; the step ends by handing them over
  BeamTable table;        // of the scan's header; the one of the scan before serves where that is the same
  Buffer<float> ranges;   // [m] by beam
  LocalWalls walls;       // of a split that is being tried
  Centerline line;        // and its centerline
  Spline spline;          // of the path
  Buffer<double> widths;  // [m] that one scan tells
  Buffer<ControlPoint> control_points;  // of the minimum-curvature path
};

}  // namespace firstlap
