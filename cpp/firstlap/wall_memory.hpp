// Walls that have just gone out of sight: behind the car, past the field of view, or hidden by an apex.
#pragma once

#include <span>

#include "firstlap/params.hpp"
#include "firstlap/scan.hpp"
#include "firstlap/walls_seen.hpp"

namespace firstlap {

// Range of every beam used, 0 where nothing came back.
void ranges_by_beam(const Buffer<ScanPoint>& points, std::size_t beams, Buffer<float>& ranges) noexcept;

// Appends to `walls` those samples of `before` (already in today's base_link) that this scan could not
// have seen. What the scan sees itself, or sees through, is forgotten.
void recall_hidden(const WallsSeen& before, const BeamTable& table, const Buffer<float>& ranges, const CarGeometry& car,
                   double memory_time, WallsSeen& walls) noexcept;

}  // namespace firstlap
