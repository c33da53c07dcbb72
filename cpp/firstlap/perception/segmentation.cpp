#include "firstlap/perception/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

double distance(const ScanPoint& a, const ScanPoint& b) noexcept { return norm(a.x - b.x, a.y - b.y); }

// Borges and Aldon (2004) with the smaller range, after Dietmayer: distance between two returns `angle` apart, per
// meter of range, on a wall at the smallest allowed angle of incidence.
double breakpoint_ratio(double angle, double break_angle) noexcept {
  const double incidence = std::max(break_angle, 2.0 * angle);
  return std::sin(angle) / std::sin(incidence - angle);
}

// Maximum distance between neighboring returns of one wall.
class BreakLimit {
 public:
  BreakLimit(double angle_step, double beam_step, double passable, const SegmentationParams& params) noexcept
      : params_(params),
        angle_step_(angle_step),
        neighbor_ratio_(breakpoint_ratio(angle_step, params.break_angle)),
        beam_step_(beam_step),
        passable_(passable),
        beam_gap_(static_cast<int>(std::lround(static_cast<double>(params.max_beam_gap) * beam_step))) {}

  // Maximum number of beams between them.
  [[nodiscard]] int beam_gap() const noexcept { return beam_gap_; }
  // [m] Distance expected after a return at `range` [m], before any distance is known.
  [[nodiscard]] double first_mean(double range) const noexcept { return 2.0 * range * angle_step_; }
  // Lower bound of the limit, which does not depend on the wall's direction.
  [[nodiscard]] double floor(double range, double beams) const noexcept {
    return std::max(params_.break_min, 2.0 * range * (beams * angle_step_));
  }
  // `mean` [m] is the weighted mean of the previous distances.
  [[nodiscard]] double limit(const ScanPoint& a, const ScanPoint& b, double beams, double mean) const noexcept {
    const double range = std::min(a.range, b.range);
    const double lowest = floor(range, beams);
    const double ratio = beams == 1.0 ? neighbor_ratio_ : breakpoint_ratio(beams * angle_step_, params_.break_angle);
    const double adaptive = range * ratio + 3.0 * params_.range_sigma;
    const double trend = params_.mean_factor * mean * beams;
    // In a thinned scan the limit grows with the number of missing beams, up to the scan's typical step; but a passable
    // gap is always a break.
    const double highest = std::min(params_.break_max * std::min(beams, beam_step_), passable_);
    return std::clamp(std::max(adaptive, trend), lowest, std::max(lowest, highest));
  }

 private:
  const SegmentationParams& params_;
  double angle_step_;
  double neighbor_ratio_;
  double beam_step_;
  double passable_;  // [m] minimum width of a passable gap
  int beam_gap_;
};

// `gain`: of the low-pass filter of the distances.
void break_into_sections(const Buffer<ScanPoint>& points, const BreakLimit& limit, double gain,
                         Buffer<Section>& sections) noexcept {
  const int gap_limit = limit.beam_gap();
  double mean = limit.first_mean(points[0].range);
  std::size_t first = 0;
  for (std::size_t j = 1; j < points.size(); ++j) {
    const ScanPoint& a = points[j - 1];
    const ScanPoint& b = points[j];
    const int gap = b.beam - a.beam;
    const auto beams = static_cast<double>(gap);
    const double d = distance(a, b);
    // Most neighbors are so close that the full limit need not be computed.
    const bool is_near = d <= limit.floor(std::min(a.range, b.range), beams);
    if (gap <= gap_limit && (is_near || d <= limit.limit(a, b, beams, mean))) {
      mean += gain * ((gap == 1 ? d : d / beams) - mean);
      continue;
    }
    if (!sections.push({first, j - 1})) return;
    first = j;
    mean = limit.first_mean(b.range);
  }
  sections.push({first, points.size() - 1});
}

void measure(const Buffer<ScanPoint>& points, Section& section) noexcept {
  section.nearest = points[section.first].range;
  section.middle = section.first;
  for (std::size_t i = section.first; i <= section.last; ++i) {
    if (points[i].range >= section.nearest) continue;
    section.nearest = points[i].range;
    section.middle = i;
  }
  const ScanPoint& first = points[section.first];
  const ScanPoint& last = points[section.last];
  section.length = distance(first, last);
  section.angle = std::atan2(std::abs(last.y - first.y), std::abs(last.x - first.x));
}

void merge_neighbors(const Buffer<ScanPoint>& points, double merge_distance, Buffer<Section>& sections) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 1; i < sections.size(); ++i) {
    if (distance(points[sections[kept].last], points[sections[i].first]) < merge_distance)
      sections[kept].last = sections[i].last;
    else
      sections[++kept] = sections[i];
  }
  sections.shrink(kept + 1);
}

void eliminate(const SegmentationParams& params, double beam_step, Section& section) noexcept {
  const double points_needed = std::max(2.0, static_cast<double>(params.min_points) / beam_step);
  const auto count = static_cast<double>(section.last - section.first + 1);
  if (count < points_needed || section.length < params.min_chord) section.status = SectionStatus::too_small;
  if (section.angle > params.max_angle) section.status = SectionStatus::across;
  if (section.nearest > params.max_nearest) section.status = SectionStatus::too_far;
}

// Whether all sections between i and k lie behind the gap from the end of i to the start of k.
bool lie_behind_gap(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, std::size_t i,
                    std::size_t k) noexcept {
  const double gap_range = std::min(points[sections[i].last].range, points[sections[k].first].range);
  for (std::size_t between = i + 1; between < k; ++between)
    if (sections[between].status != SectionStatus::seen_through && sections[between].nearest < gap_range) return false;
  return true;
}

// Pipes have gaps at their joints, through which the LiDAR sees what is behind; it also sees over low walls. If the gap
// between two sections is too narrow to drive through, sections visible in it are not part of the track. A piece of
// pipe may be too small to be kept, but counts as wall next to a kept one.
void drop_seen_through(const Buffer<ScanPoint>& points, double gap, std::size_t reach,
                       Buffer<Section>& sections) noexcept {
  if (reach == 0) return;
  const auto is_solid = [](const Section& s) {
    return s.status == SectionStatus::kept || (s.status == SectionStatus::too_small && s.last - s.first >= 2);
  };
  for (std::size_t i = 0; i + 1 < sections.size(); ++i) {
    if (!is_solid(sections[i])) continue;
    const std::size_t end = std::min(sections.size(), i + 2 + reach);
    for (std::size_t k = i + 1; k < end; ++k) {
      if (!is_solid(sections[k])) continue;
      if (distance(points[sections[i].last], points[sections[k].first]) >= gap) continue;
      if (!lie_behind_gap(points, sections, i, k)) continue;
      for (std::size_t between = i + 1; between < k; ++between) sections[between].status = SectionStatus::seen_through;
      if (sections[i].status == SectionStatus::kept || sections[k].status == SectionStatus::kept)
        sections[i].status = sections[k].status = SectionStatus::kept;
      break;
    }
  }
}

}  // namespace

double median_beam_step(const Buffer<ScanPoint>& points) noexcept {
  constexpr std::size_t bins = 64;
  if (points.size() < 2) return 1.0;
  const std::size_t steps = points.size() - 1;
  const auto beams = static_cast<std::size_t>(points.back().beam - points.front().beam);
  if (2 * (beams - steps) <= steps) return 1.0;  // so few beams are lost that most returns are neighbors

  std::array<std::size_t, bins> count{};
  for (std::size_t j = 0; j < steps; ++j)
    ++count[std::min(bins - 1, static_cast<std::size_t>(points[j + 1].beam - points[j].beam))];
  std::size_t median = 0;
  for (std::size_t seen = count[0]; 2 * seen < steps; seen += count[median]) ++median;
  return static_cast<double>(median);
}

double passable_gap(double width, const SegmentationParams& params) noexcept {
  return std::clamp(params.pass_ratio * width, params.pass_min, params.pass_max);
}

void segment(const Buffer<ScanPoint>& points, double angle_step, double width, const SegmentationParams& params,
             Buffer<Section>& sections) noexcept {
  sections.clear();
  if (points.empty()) return;
  const double beam_step = median_beam_step(points);
  const double passable = passable_gap(width, params);
  break_into_sections(points, BreakLimit(angle_step, beam_step, passable, params), params.mean_gain, sections);
  merge_neighbors(points, params.merge_distance, sections);
  for (Section& section : sections) {
    measure(points, section);
    eliminate(params, beam_step, section);
  }
  drop_seen_through(points, passable, static_cast<std::size_t>(params.seen_through), sections);
}

}  // namespace firstlap
