// Step 4: the centerline: the side that represents the track, offset by half the local width; where both walls are
// visible, the line equally far from both. It is traced from the car, forward and a little backward, as the zero set of
// (distance to the right wall - distance to the left wall). Every point therefore keeps its distance to the whole wall,
// and no corner can fold the line (docs/adr/).
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/track_width.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

inline constexpr std::size_t max_line_points = 512;

// Walls that support a centerline point.
enum class WallSupport : std::uint8_t { none, right, left, both };

struct CenterlinePoint {
  double x = 0.0;  // [m] base_link
  double y = 0.0;  // [m] base_link
  double width = 0.0;
  WallSupport support = WallSupport::none;
  Point2 right;
  Point2 left;
  bool wide = false;  // both walls are there, but farther apart than the track can be: the nearer one counts

  static constexpr auto columns() {
    using C = CenterlinePoint;
    return std::tuple{
        Column{"points",
               [](const C& p) {
                 return Point2{p.x, p.y};
               },
               "m", "from behind the car to the horizon"},
        Column{"width", &C::width, "m", "measured if both walls support the point, else estimated"},
        Column{"support", &C::support, "", "walls that support each point: 0 none, 1 right, 2 left, 3 both"},
        Column{"right", &C::right, "m", "nearest sample of the right wall"},
        Column{"left", &C::left, "m", "nearest sample of the left wall"},
    };
  }
};

// Reason for the end of a centerline.
enum class LineEnd : std::uint8_t { none, length, end_of_view, too_narrow, turns_back };

struct Centerline {
  Centerline() : points(max_line_points) {}
  Buffer<CenterlinePoint> points;
  std::size_t nearest = 0;
  double ahead = 0.0;
  LineEnd end = LineEnd::none;

  static constexpr auto columns() {
    using C = Centerline;
    return std::tuple{
        Part{&C::points},
        Column{"nearest", &C::nearest, "", "index of the point nearest to the front axle"},
        Column{"ahead", &C::ahead, "m", "length ahead of the front axle"},
        Column{"end", &C::end, "", "reason for its end: 0 none, 1 length, 2 end of view, 3 too narrow, 4 turns back"},
    };
  }
};

// What the centerline is traced from, in base_link.
struct LineScene {
  const LocalWalls& walls;
  const Buffer<TrailPoint>& trail;
  double width;  // [m] remembered track width
};

// Parameters of the centerline.
struct LineLimits {
  const CarGeometry& car;
  const TrackWidthParams& width;
  const CenterlineParams& line;
};

// Traces the centerline between the walls. Fewer than four points are no usable centerline.
void trace_centerline(const LineScene& scene, const LineLimits& limits, Centerline& line) noexcept;

}  // namespace firstlap
