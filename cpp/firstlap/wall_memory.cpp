#include "firstlap/wall_memory.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/geometry.hpp"

namespace firstlap {
namespace {

// True where nothing that this scan measured speaks about (x, y) in the laser's frame.
bool is_hidden(double x, double y, const BeamTable& table, const Buffer<float>& ranges) noexcept {
  constexpr double clear = 0.2;  // [m] a wall this much nearer hides what is behind
  const double position = (std::atan2(y, x) - table.angle_first()) / table.angle_step();
  if (position < 0.0 || position > static_cast<double>(ranges.size()) - 1.0) return true;
  const auto beam = static_cast<std::size_t>(position);
  const std::size_t first = beam > 2 ? beam - 2 : 0;
  const std::size_t last = std::min(beam + 2, ranges.size() - 1);
  float seen = 0.0F;
  for (std::size_t i = first; i <= last; ++i) seen = std::max(seen, ranges[i]);
  return seen == 0.0F || static_cast<double>(seen) < norm(x, y) - clear;
}

void recall_side(const WallSide& before, const BeamTable& table, const Buffer<float>& ranges, const CarGeometry& car,
                 double memory_time, WallSide& side) noexcept {
  constexpr double reach = 3.0;  // [m] what is further behind serves nobody
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto x = static_cast<double>(before.x[i]);
    const auto y = static_cast<double>(before.y[i]);
    if (static_cast<double>(before.age[i]) > memory_time || x < -reach) continue;
    if (is_hidden(x - car.laser_x, y, table, ranges)) side.push(x, y, before.outward[i], before.age[i]);
  }
}

}  // namespace

void ranges_by_beam(const Buffer<ScanPoint>& points, std::size_t beams, Buffer<float>& ranges) noexcept {
  ranges.clear();
  for (std::size_t i = 0; i < beams; ++i) ranges.push(0.0F);
  for (const ScanPoint& p : points) ranges[static_cast<std::size_t>(p.beam)] = static_cast<float>(p.range);
}

void recall_hidden(const WallsSeen& before, const BeamTable& table, const Buffer<float>& ranges,
                   const CarGeometry& car, double memory_time, WallsSeen& walls) noexcept {
  recall_side(before.left, table, ranges, car, memory_time, walls.left);
  recall_side(before.right, table, ranges, car, memory_time, walls.right);
}

}  // namespace firstlap
