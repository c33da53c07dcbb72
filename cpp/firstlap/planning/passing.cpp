#include "firstlap/planning/passing.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {

double clearance_score(const Centerline& line, const CarGeometry& car, const CenterlineParams& params) noexcept {
  const double reach = params.clear_reach;
  const double enough = params.clear_enough;
  double clearance = enough;
  double length = 0.0;
  for (std::size_t i = line.nearest; i < line.points.size() && length < reach; ++i) {
    const CenterlinePoint& c = line.points[i];
    const double right = norm(c.x - c.right.x, c.y - c.right.y);
    const double left = norm(c.x - c.left.x, c.y - c.left.y);
    clearance = std::min(clearance, std::min(right, left) - 0.5 * car.width);
    if (i > line.nearest) length += norm(c.x - line.points[i - 1].x, c.y - line.points[i - 1].y);
  }
  return std::clamp(clearance / enough, params.clear_score_min, 1.0);
}

double side_consistency(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split,
                        const SegmentationParams& params) noexcept {
  const double factor = params.side_change_score;
  double score = 1.0;
  for (std::size_t i = 0; i < samples.size();) {
    const std::size_t section = samples[i].section;
    int votes = 0;
    int count = 0;
    for (; i < samples.size() && samples[i].section == section; ++i, ++count) votes += samples[i].vote;
    const bool to_right = section < split;
    if (sections[section].status == SectionStatus::kept && 2 * std::abs(votes) > count && (votes < 0) != to_right)
      score *= factor;
  }
  return std::max(score, factor * factor);
}

}  // namespace firstlap
