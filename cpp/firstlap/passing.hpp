// On which side to pass what stands on the track. A split says it for every section; these two say how good that is.
#pragma once

#include "firstlap/centerline.hpp"
#include "firstlap/sides.hpp"

namespace firstlap {

// 1 where the line leaves the car room on both sides over the next metres, less where it becomes tight.
double ease_of_passing(const Centerline& line, const CarGeometry& car) noexcept;

// 1 where every section keeps the side that it had, less for each whole section that would change it: half-way
// past an obstacle is no place to think again.
double loyalty(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split) noexcept;

}  // namespace firstlap
