#include "firstlap/planning/passing.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {

double clearance_score(const Centerline& line, const CarGeometry& car, const CenterlineParams& params) noexcept {
  const double reach = params.clear_reach;
  const double plenty = params.clear_enough;
  double room = plenty;
  double way = 0.0;
  for (std::size_t i = line.nearest; i < line.points.size() && way < reach; ++i) {
    const CenterlinePoint& c = line.points[i];
    const double right = norm(c.x - c.right.x, c.y - c.right.y);
    const double left = norm(c.x - c.left.x, c.y - c.left.y);
    room = std::min(room, std::min(right, left) - 0.5 * car.width);
    if (i > line.nearest) way += norm(c.x - line.points[i - 1].x, c.y - line.points[i - 1].y);
  }
  return std::clamp(room / plenty, params.clear_score_min, 1.0);
}

double side_consistency(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split,
                        const SegmentationParams& params) noexcept {
  const double price = params.side_change_score;
  double worth = 1.0;
  for (std::size_t i = 0; i < samples.size();) {
    const std::size_t section = samples[i].section;
    int votes = 0;
    int count = 0;
    for (; i < samples.size() && samples[i].section == section; ++i, ++count) votes += samples[i].vote;
    const bool to_right = section < split;
    if (sections[section].status == SectionStatus::kept && 2 * std::abs(votes) > count && (votes < 0) != to_right)
      worth *= price;
  }
  return std::max(worth, price * price);
}

}  // namespace firstlap
