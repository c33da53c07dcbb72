// Walls that have just become occluded: behind the car, outside the field of view, or hidden by an apex.
#pragma once

#include <span>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap {

// Range [m] of every used beam, 0 without a return.
void ranges_by_beam(const Buffer<ScanPoint>& points, std::size_t beams, Buffer<float>& ranges) noexcept;

// The beams of a scan.
struct SeenBeams {
  const BeamTable& table;
  const Buffer<float>& ranges;  // [m] of every used beam, 0 without a return
  const CarGeometry& car;
};

// Appends to `walls` the samples of `before` (already in the current base_link) that are occluded in this scan. Samples
// that the scan could have measured, or sees through, are dropped. `memory_time` [s] limits their age.
void carry_over_occluded(const LocalWalls& before, const SeenBeams& beams, double memory_time,
                         LocalWalls& walls) noexcept;

}  // namespace firstlap
