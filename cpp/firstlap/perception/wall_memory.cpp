#include "firstlap/perception/wall_memory.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

// Whether a point is occluded in this scan.
bool is_hidden(Point2 point, const SeenBeams& beams) noexcept {
  constexpr double clear = 0.2;  // [m] a wall closer by this occludes what is behind it
  const auto& [table, ranges, car] = beams;
  const double x = point.x - car.laser_x;
  const double y = point.y - car.laser_y;
  const double position = (std::atan2(y, x) - table.angle_first()) / table.angle_step();
  if (position < 0.0 || position > static_cast<double>(ranges.size()) - 1.0) return true;
  const auto beam = static_cast<std::size_t>(position);
  const std::size_t first = beam > 2 ? beam - 2 : 0;
  const std::size_t last = std::min(beam + 2, ranges.size() - 1);
  float seen = 0.0F;
  for (std::size_t i = first; i <= last; ++i) seen = std::max(seen, ranges[i]);
  return seen == 0.0F || static_cast<double>(seen) < norm(x, y) - clear;
}

// Marks sample `end` as a visible end of the wall that comes from `inner`, unless the wall continues there in this
// scan.
void mark_end(std::size_t end, std::size_t inner, WallSearch& seen, WallSide& side) noexcept {
  constexpr double joined = 0.5;  // [m]
  const Point2 e = side.at(end);
  if (seen.distance(e.x, e.y, joined) < joined) return;
  const Point2 from = side.at(inner);
  const double length = norm(e.x - from.x, e.y - from.y);
  if (length > 1e-6) side.outward[end] = {(e.x - from.x) / length, (e.y - from.y) / length};
}

// Marks the ends of the run of samples from `run` to the last one.
void close_run(std::size_t run, WallSearch& seen, WallSide& side) noexcept {
  if (side.size() == run) return;
  if (side.size() == run + 1) side.outward[run] = {1.0, 0.0};  // a single sample does not tell how the wall continues
  if (side.size() < run + 2) return;
  const std::size_t last = side.size() - 1;
  mark_end(run, std::min(last, run + 2), seen, side);
  mark_end(last, last >= run + 2 ? last - 2 : run, seen, side);
}

// Scans run from behind the car forward along the right wall, so its older samples come first; along the left wall they
// come last.
void recall_side(const WallSide& before, const SeenBeams& beams, double memory_time, bool oldest_first,
                 WallSide& side) noexcept {
  constexpr double reach = 3.0;    // [m] samples farther behind are dropped
  constexpr double one_run = 0.5;  // [m] samples within this distance belong to one wall
  constexpr double same = 0.3;     // [m] samples this close to a wall in this scan are redundant
  side.seen = side.size();
  const std::size_t first = oldest_first ? before.seen : 0;
  std::size_t run = side.seen;  // first sample of the current run
  WallSearch seen(side, side.seen);
  for (std::size_t k = 0; k < before.size(); ++k) {
    const std::size_t i = (first + k) % before.size();
    const Point2 p = before.at(i);
    if (static_cast<double>(before.age[i]) > memory_time || p.x < -reach) continue;
    if (seen.distance(p.x, p.y, same) < same) continue;
    if (!is_hidden(p, beams)) continue;
    if (side.size() > run && norm(p.x - side.at(side.size() - 1).x, p.y - side.at(side.size() - 1).y) > one_run) {
      close_run(run, seen, side);
      run = side.size();
    }
    side.push(p.x, p.y, {}, before.age[i], before.sight[i]);
  }
  close_run(run, seen, side);
}

}  // namespace

void ranges_by_beam(const Buffer<ScanPoint>& points, std::size_t beams, Buffer<float>& ranges) noexcept {
  ranges.fill(beams, 0.0F);
  for (const ScanPoint& p : points) ranges[static_cast<std::size_t>(p.beam)] = static_cast<float>(p.range);
}

void carry_over_occluded(const LocalWalls& before, const SeenBeams& beams, double memory_time,
                         LocalWalls& walls) noexcept {
  recall_side(before.left, beams, memory_time, false, walls.left);
  recall_side(before.right, beams, memory_time, true, walls.right);
}

}  // namespace firstlap
