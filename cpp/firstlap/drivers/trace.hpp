// The results of all stages of one step, for plots, logs, live views and tests. The method never reads them.
#pragma once

#include <tuple>

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
  Buffer<Section> sections;       // of the points
  Buffer<SectionSample> samples;  // samples of the sections, with their previous sides
  Candidates candidates;          // splits, best first
  std::size_t split = 0;          // the chosen split: sections before it are right, from it on left
  LocalWalls walls;               // by side, including remembered samples
  Centerline line;                // equally far from both walls
  Buffer<Point2> smoothed;        // centerline after Laplacian smoothing and the join to the car
  Buffer<Point2> simplified;      // after Opheim simplification
  Buffer<TrajectoryPoint> path;   // spline with velocity profile
  std::size_t nearest = 0;        // index of the path point nearest to the front axle
  TrajectoryPoint lookahead;      // the point used by the steering
  SteeringTerms steering;         // terms of the steering angle
  double width = 0.0;             // [m] remembered track width
  double clearance = 0.0;         // [m] smallest distance of the path ahead to a wall
  double speed_scale = 1.0;       // true speed per measured speed, as used
  double command_scale = 1.0;     // true speed per commanded speed, as used
  StepResult result{};

  // Resets all results.
  void clear() noexcept;

  static constexpr auto columns() {
    using C = Trace;
    return std::tuple{
        Part{&C::points},
        Column{"sections", &C::sections, "", "of the points"},
        Part{&C::samples},
        Column{"candidates", &C::candidates, "", "splits with their scores, best first"},
        Column{"split", &C::split, "", "the chosen split: sections before it are right, from it on left"},
        Column{"left", [](const C& t) -> const WallSide& { return t.walls.left; }, "",
               "left wall, including remembered samples"},
        Column{"right", [](const C& t) -> const WallSide& { return t.walls.right; }, "",
               "right wall, including remembered samples"},
        Column{"line", &C::line, "", "centerline, equally far from both walls"},
        Column{"smoothed", &C::smoothed, "m", "centerline after Laplacian smoothing and the join to the car"},
        Column{"simplified", &C::simplified, "m", "centerline after Opheim simplification"},
        Column{"path", &C::path, "", "spline with velocity profile"},
        Column{"nearest", &C::nearest, "", "index of the path point nearest to the front axle"},
        Column{"lookahead", &C::lookahead, "", "the path point used by the steering"},
        Column{"steering", &C::steering, "", "terms of the steering angle"},
        Column{"width", &C::width, "m", "remembered track width"},
        Column{"clearance", &C::clearance, "m", "smallest distance of the path ahead to a wall"},
        Column{"speed_scale", &C::speed_scale, "", "true speed per measured speed, as used"},
        Column{"command_scale", &C::command_scale, "", "true speed per commanded speed, as used"},
        Column{"result", &C::result, "", "speed, steering angle and status"},
    };
  }
};

}  // namespace firstlap
