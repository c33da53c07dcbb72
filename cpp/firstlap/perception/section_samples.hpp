// Step 2, between sections and sides: evenly spaced samples of the sections, labeled with their previous side.
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/segmentation.hpp"

namespace firstlap {

// A sample of a section: the mean of its points over one spacing.
struct SectionSample {
  double x = 0.0;           // [m] base_link
  double y = 0.0;           // [m] base_link
  std::size_t section = 0;  // index of its section
  int vote = 0;             // previous side: +1 left, -1 right, 0 unknown
  Sight sight{};            // past the end of the section, at its first and last sample

  static constexpr auto columns() {
    using C = SectionSample;
    return std::tuple{
        Column{"samples",
               [](const C& s) {
                 return Point2{s.x, s.y};
               },
               "m", "of the sections, evenly spaced"},
        Column{"sample_section", &C::section, "", "index of each sample's section"},
        Column{"sample_vote", [](const C& s) { return static_cast<std::int8_t>(s.vote); }, "",
               "previous side of each sample: 1 left, -1 right, 0 unknown"},
    };
  }
};

// A scan after segmentation and sampling.
struct SegmentedScan {
  const Buffer<ScanPoint>& points;
  const Buffer<Section>& sections;
  const Buffer<SectionSample>& samples;
};

// Samples of all sections except those seen through gaps, about `spacing` [m] apart, in scan order.
void sample_sections(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, const CarGeometry& car,
                     double spacing, const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept;

// Labels each sample with its previous side: that of an earlier wall sample nearby, else its side of the previous path
// or of the car's trail. All inputs are in the current base_link.
void label_from_history(const LocalWalls& before, const Buffer<TrajectoryPoint>& path, const Buffer<TrailPoint>& trail,
                        const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept;

}  // namespace firstlap
