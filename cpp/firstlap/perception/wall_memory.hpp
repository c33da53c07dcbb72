// Walls that have just gone out of sight: behind the car, past the field of view, or hidden by an apex.
#pragma once

#include <span>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap {

// Range of every beam used, 0 where nothing came back.
void ranges_by_beam(const Buffer<ScanPoint>& points, std::size_t beams, Buffer<float>& ranges) noexcept;

// Appends to `walls` those samples of `before` (already in today's base_link) that this scan could not
// have seen. What the scan sees itself, or sees through, is forgotten.
void carry_over_occluded(const LocalWalls& before, const BeamTable& table, const Buffer<float>& ranges,
                         const CarGeometry& car, double memory_time, LocalWalls& walls) noexcept;

}  // namespace firstlap
