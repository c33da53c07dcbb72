// Step 2, continued: assigns sections to the right and left wall. In scan order the right wall comes first and the left
// wall last; the track continues between them. The assignment is therefore a single number: the split, the index of the
// first left section.
#pragma once

#include <array>
#include <tuple>

#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/section_samples.hpp"
#include "firstlap/perception/segmentation.hpp"

namespace firstlap {

struct SplitCandidate {
  std::size_t split = 0;
  double score = 0.0;

  static constexpr auto columns() {
    using C = SplitCandidate;
    return std::tuple{
        Column{"split", &C::split, "", "sections before it are right, from it on left"},
        Column{"score", &C::score, "", "higher is better"},
    };
  }
};

inline constexpr std::size_t max_candidates = 3;

struct Candidates {
  std::array<SplitCandidate, max_candidates> items{};  // best first
  std::size_t count = 0;

  [[nodiscard]] std::size_t size() const noexcept { return count; }
  [[nodiscard]] auto begin() const noexcept { return items.begin(); }
  [[nodiscard]] auto end() const noexcept { return items.begin() + static_cast<std::ptrdiff_t>(count); }
};

// The best splits, ranked by the depth of the gap and the agreement with previous labels. `width` [m] is the remembered
// track width.
Candidates rank_splits(const SegmentedScan& scan, double width, const SegmentationParams& params) noexcept;

// Input of split_into_sides.
struct Split {
  std::size_t at = 0;    // sections before it are right, from it on left
  double width = 0.0;    // [m] remembered track width: gaps that are not passable are bridged
  double spacing = 0.0;  // [m] of wall samples
};

// The wall samples of each side for one split, with small gaps bridged and visible ends marked.
void split_into_sides(const SegmentedScan& scan, const Split& split, const CarGeometry& car,
                      const SegmentationParams& params, LocalWalls& walls) noexcept;

}  // namespace firstlap
