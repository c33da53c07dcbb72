// On which side to pass what stands on the track. A split says it for every section; these two say how good that is.
#pragma once

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/perception/sides.hpp"
#include "firstlap/planning/centerline.hpp"

namespace firstlap {

// 1 where the line leaves the car room on both sides over the next meters, less where it becomes tight.
double clearance_score(const Centerline& line, const CarGeometry& car, const CenterlineParams& params) noexcept;

// 1 where every section keeps the side that it had, less for each whole section that would change it: half-way
// past an obstacle is no place to think again.
double side_consistency(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split,
                        const SegmentationParams& params) noexcept;

}  // namespace firstlap
