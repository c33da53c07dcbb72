// Step 2, continued: which sections are the right wall and which the left. In scan order the right wall
// comes first and the left wall last; between them lies the way on. So one number tells all: the
// split, the first section that is left.
#pragma once

#include <array>

#include "firstlap/segmentation.hpp"
#include "firstlap/types.hpp"
#include "firstlap/walls_seen.hpp"

namespace firstlap {

// A sample of a section's surface: the mean of its points over one spacing.
struct SectionSample {
  double x = 0.0;           // [m] base_link
  double y = 0.0;           // [m] base_link
  std::size_t section = 0;  // index of its section
  int vote = 0;             // +1 it was left before, -1 it was right, 0 not known
  Sight sight{};            // past the section's end, at its first and last sample
};

struct SplitCandidate {
  std::size_t split = 0;  // sections before it are right, from it on left
  double score = 0.0;
};

inline constexpr std::size_t max_candidates = 3;

struct Candidates {
  std::array<SplitCandidate, max_candidates> items{};  // best first
  std::size_t count = 0;
};

// Samples of all sections that are not seen through, about `spacing` apart, in scan order.
void sample_sections(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, const CarGeometry& car,
                     double spacing, Buffer<SectionSample>& samples) noexcept;

// Gives each sample the side that it had in the past: that of a wall sample seen there before, or of
// the side of the previous path or of the car's trail on which it lies. All are in today's base_link.
void vote_by_past(const WallsSeen& before, const Buffer<TrajectoryPoint>& path, const Buffer<TrailPoint>& trail,
                  const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept;

// The best splits by depth of the gap and agreement with the past.
Candidates rank_splits(const Buffer<ScanPoint>& points, const Buffer<Section>& sections,
                       const Buffer<SectionSample>& samples, double width, const CarGeometry& car,
                       const SegmentationParams& params) noexcept;

// The wall samples of each side for one split, with small gaps bridged and visible ends marked.
void split_into_sides(const Buffer<ScanPoint>& points, const Buffer<Section>& sections,
                      const Buffer<SectionSample>& samples, std::size_t split, const CarGeometry& car, double spacing,
                      double bridge, double chain_gap, WallsSeen& walls) noexcept;

}  // namespace firstlap
