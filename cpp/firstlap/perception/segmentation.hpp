// Step 2: segments the point cloud into wall sections: break, merge, eliminate, drop what is seen through gaps.
// sides.hpp then assigns the sections to the left and right wall.
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/perception/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap {

inline constexpr std::size_t max_sections = 256;

enum class SectionStatus : std::uint8_t { kept, too_small, too_far, seen_through, across };

// Points [first, last] in scan order.
struct Section {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t middle = 0;  // index of the point nearest to the LiDAR
  double nearest = 0.0;    // [m] range of that point
  double length = 0.0;
  double angle = 0.0;  // [rad] between its chord and the car's heading, 0 to pi/2
  SectionStatus status = SectionStatus::kept;

  static constexpr auto columns() {
    using C = Section;
    return std::tuple{
        Column{"first", &C::first, "", "index of its first point"},
        Column{"last", &C::last, "", "index of its last point"},
        Column{"nearest", &C::nearest, "m", "range of its nearest point"},
        Column{"length", &C::length, "m", "chord from the first to the last point"},
        Column{"angle", &C::angle, "rad", "between the chord and the car's heading, 0 to pi/2"},
        Column{"status", &C::status, "", "0 kept, 1 too small, 2 too far, 3 seen through a gap, 4 across the heading"},
    };
  }
};

// Density of the scan: median number of beams from one valid return to the next (1 if no beams are lost).
double median_beam_step(const Buffer<ScanPoint>& points) noexcept;

// Breaks the points into sections and sets their status. `angle_step` [rad] is the angle between beams. `width` [m] is
// the remembered track width, which sets the width of a passable gap.
void segment(const Buffer<ScanPoint>& points, double angle_step, double width, const SegmentationParams& params,
             Buffer<Section>& sections) noexcept;

// Minimum width [m] of a passable gap.
double passable_gap(double width, const SegmentationParams& params) noexcept;

}  // namespace firstlap
