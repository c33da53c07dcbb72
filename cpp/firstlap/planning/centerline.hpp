// Step 4: the centerline. The more representative side is moved by half the local width; where both
// sides are seen, that is the line equally far from both. It is traced from the car, forwards and a
// little backwards, as the zero set of (distance to the right wall - distance to the left wall), so that
// every point keeps its distance to the whole wall and no corner can fold it (docs/adr/).
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

// What a centerline point stands on.
enum class Support : std::uint8_t { none, right, left, both };

struct CenterlinePoint {
  double x = 0.0;  // [m] base_link
  double y = 0.0;  // [m] base_link
  double width = 0.0;
  Support support = Support::none;
  Point2 right;
  Point2 left;
  bool wide = false;  // both walls stand here, further apart than the track can be: the nearer one counts

  static constexpr auto columns() {
    using C = CenterlinePoint;
    return std::tuple{
        Column{"points",
               [](const C& p) {
                 return Point2{p.x, p.y};
               },
               "m", "from behind the car to the horizon"},
        Column{"width", &C::width, "m", "measured where both sides support it, else estimated"},
        Column{"support", &C::support, "", "what each point stands on: 0 none, 1 right, 2 left, 3 both"},
        Column{"right", &C::right, "m", "nearest sample of the right wall"},
        Column{"left", &C::left, "m", "nearest sample of the left wall"},
    };
  }
};

// Why a line ends where it does.
enum class LineEnd : std::uint8_t { none, length, unseen, narrow, turns_back };

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
        Column{"nearest", &C::nearest, "", "index of the point next to the front axle"},
        Column{"ahead", &C::ahead, "m", "of line ahead of the front axle"},
        Column{"end", &C::end, "", "why the line ends: 0 none, 1 length, 2 unseen, 3 narrow, 4 turns back"},
    };
  }
};

// Traces the line between `walls`. `width` [m] is the remembered one. Fewer than four points: no line.
void trace_centerline(const LocalWalls& walls, const Buffer<TrailPoint>& trail, double width, const CarGeometry& car,
                      const TrackWidthParams& width_params, const CenterlineParams& params, Centerline& line) noexcept;

}  // namespace firstlap
