// The results of every stage of one step: what pictures, logs, live views and tests look at, and nothing else does.
#pragma once

#include "firstlap/control/stanley.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/scan.hpp"
#include "firstlap/perception/segmentation.hpp"
#include "firstlap/perception/sides.hpp"
#include "firstlap/planning/centerline.hpp"
#include "firstlap/planning/trajectory.hpp"

namespace firstlap {

struct Trace {
  Trace()
      : points(max_points),
        sections(max_sections),
        samples(max_samples),
        smoothed(max_line_points),
        simplified(max_line_points),
        path(max_path_points) {}

  Buffer<ScanPoint> points;       // valid returns
  Buffer<Section> sections;       // and their sections
  Buffer<SectionSample> samples;  // and the walls' samples, with votes of the past
  Candidates candidates;          // the splits that were considered, best first
  std::size_t split = 0;          // the chosen one: sections before it are right, from it on left
  LocalWalls walls;               // by side, with what is remembered
  Centerline line;                // equally far from both
  Buffer<Point2> smoothed;        // after Laplacian smoothing and the join to the car
  Buffer<Point2> simplified;      // after Opheim
  Buffer<TrajectoryPoint> path;   // the spline with its speeds
  std::size_t nearest = 0;        // path point next to the front axle
  TrajectoryPoint lookahead;      // the point that steering looks at
  SteeringTerms steering;         // how the angle came about
  double width = 0.0;             // [m] remembered track width
  double clearance = 0.0;         // [m] smallest distance of the path ahead to any wall
  double speed_scale = 1.0;       // true speed per measured, as taken
  double command_scale = 1.0;     // true speed per commanded, as taken
  StepResult result{};

  // Nothing was seen or planned yet.
  void clear() noexcept;
};

}  // namespace firstlap
