// Step 2, between sections and sides: samples of the sections' surfaces, evenly spaced, with the side that they had
// before.
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/segmentation.hpp"

namespace firstlap {

// A sample of a section's surface: the mean of its points over one spacing.
struct SectionSample {
  double x = 0.0;           // [m] base_link
  double y = 0.0;           // [m] base_link
  std::size_t section = 0;  // index of its section
  int vote = 0;             // +1 it was left before, -1 it was right, 0 not known
  Sight sight{};            // past the section's end, at its first and last sample

  static constexpr auto columns() {
    using C = SectionSample;
    return std::tuple{
        Column{"samples",
               [](const C& s) {
                 return Point2{s.x, s.y};
               },
               "m", "of the sections, evenly spaced"},
        Column{"sample_section", &C::section, "", "index of the section of each sample"},
        Column{"sample_vote", [](const C& s) { return static_cast<std::int8_t>(s.vote); }, "",
               "side of each sample before: 1 left, -1 right, 0 not known"},
    };
  }
};

// Samples of all sections that are not seen through, about `spacing` apart, in scan order.
void sample_sections(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, const CarGeometry& car,
                     double spacing, const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept;

// Gives each sample the side that it had in the past: that of a wall sample seen there before, or of
// the side of the previous path or of the car's trail on which it lies. All are in today's base_link.
void label_from_history(const LocalWalls& before, const Buffer<TrajectoryPoint>& path, const Buffer<TrailPoint>& trail,
                        const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept;

}  // namespace firstlap
