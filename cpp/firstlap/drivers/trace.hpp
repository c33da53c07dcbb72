// The results of every stage of one step: what pictures, logs, live views and tests look at, and nothing else does.
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

  static constexpr auto columns() {
    using C = Trace;
    return std::tuple{
        Part{&C::points},
        Column{"sections", &C::sections, "", "of the points"},
        Part{&C::samples},
        Column{"candidates", &C::candidates, "", "splits that were considered, with their scores, best first"},
        Column{"split", &C::split, "", "the chosen one: sections before it are right, from it on left"},
        Column{"left", [](const C& t) -> const WallSide& { return t.walls.left; }, "", "wall, with what is remembered"},
        Column{"right", [](const C& t) -> const WallSide& { return t.walls.right; }, "",
               "wall, with what is remembered"},
        Column{"line", &C::line, "", "centerline, equally far from both walls"},
        Column{"smoothed", &C::smoothed, "m", "the line after Laplacian smoothing and the join to the car"},
        Column{"simplified", &C::simplified, "m", "the line after Opheim's simplification"},
        Column{"path", &C::path, "", "the spline with its speeds"},
        Column{"nearest", &C::nearest, "", "index of the path point next to the front axle"},
        Column{"lookahead", &C::lookahead, "", "the point of the path that steering looks at"},
        Column{"steering", &C::steering, "", "how the steering angle came about"},
        Column{"width", &C::width, "m", "remembered track width"},
        Column{"clearance", &C::clearance, "m", "smallest distance of the path ahead to any wall"},
        Column{"speed_scale", &C::speed_scale, "", "true speed per measured, as taken"},
        Column{"command_scale", &C::command_scale, "", "true speed per commanded, as taken"},
        Column{"result", &C::result, "", "speed, steering angle and status"},
    };
  }
};

}  // namespace firstlap
