// A race in the simulator: three laps of a ring, 2 m wide.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "firstlap/drivers/racer.hpp"
#include "firstlap/sim/race.hpp"

namespace {

// Points of a circle around the origin, counterclockwise.
std::vector<firstlap::Point2> circle(double radius) {
  constexpr int count = 360;
  std::vector<firstlap::Point2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / count;
    points.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return points;
}

firstlap::sim::Track ring(double radius, double half_width) {
  std::vector<firstlap::sim::WallSegment> walls;
  for (const double r : {radius - half_width, radius + half_width}) {
    const std::vector<firstlap::Point2> points = circle(r);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const firstlap::Point2 a = points[i], b = points[(i + 1) % points.size()];
      walls.push_back({a.x, a.y, b.x, b.y});
    }
  }
  return {firstlap::sim::Walls(std::move(walls)), circle(radius)};
}

}  // namespace

int main() {
  const firstlap::sim::Track track = ring(5.0, 1.0);
  firstlap::Racer driver{firstlap::Params{}};
  const firstlap::sim::RaceResult result = firstlap::sim::run(track, firstlap::sim::Car{}, driver, {.laps = 3});
  for (const firstlap::sim::Lap& lap : result.laps) std::printf("%.2f s, %.2f m/s\n", lap.time, lap.mean_speed);
  std::printf("%s\n", firstlap::sim::to_string(result.outcome));
  return result.outcome == firstlap::sim::Outcome::finished ? 0 : 1;
}
