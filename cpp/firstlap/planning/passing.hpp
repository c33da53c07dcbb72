// Scores for passing an obstacle on one side or the other. A split assigns a side to every section; these scores rate
// the splits.
#pragma once

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/perception/sides.hpp"
#include "firstlap/planning/centerline.hpp"

namespace firstlap {

// 1 if the centerline has enough clearance on both sides over the next meters, less where it is tight.
double clearance_score(const Centerline& line, const CarGeometry& car, const CenterlineParams& params) noexcept;

// 1 if every section keeps its previous side, less for each whole section that would change it: the decision must not
// change halfway past an obstacle.
double side_consistency(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split,
                        const SegmentationParams& params) noexcept;

}  // namespace firstlap
