// Step 2: the point cloud into sections of wall: break, merge, eliminate, drop what is seen through gaps.
// sides.hpp then tells which sections are the left wall and which the right one.
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/perception/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap {

inline constexpr std::size_t max_sections = 256;

enum class SectionStatus : std::uint8_t { kept, too_small, too_far, seen_through };

// Points [first, last] in scan order.
struct Section {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t middle = 0;  // the point that is nearest to the laser
  double nearest = 0.0;    // [m] its range
  double length = 0.0;
  SectionStatus status = SectionStatus::kept;

  static constexpr auto columns() {
    using C = Section;
    return std::tuple{
        Column{"first", &C::first, "", "index of its first point"},
        Column{"last", &C::last, "", "index of its last point"},
        Column{"nearest", &C::nearest, "m", "range of its nearest point"},
        Column{"length", &C::length, "m", "from the first point to the last"},
        Column{"status", &C::status, "", "0 kept, 1 too small, 2 too far, 3 seen through a gap"},
    };
  }
};

// How dense this scan is: beams from one valid return to the next, in the median (1 for a whole scan).
double median_beam_step(const Buffer<ScanPoint>& points) noexcept;

// Breaks the points into sections and gives each its status. `angle_step` [rad] between beams,
// `width` [m] the remembered track width, which tells a gap from a way through.
void segment(const Buffer<ScanPoint>& points, double angle_step, double width, const SegmentationParams& params,
             Buffer<Section>& sections) noexcept;

// The narrowest gap that is a way through [m].
double passable_gap(double width, const SegmentationParams& params) noexcept;

}  // namespace firstlap
