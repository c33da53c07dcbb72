#include "firstlap/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firstlap/geometry.hpp"

namespace firstlap {
namespace {

double distance(const ScanPoint& a, const ScanPoint& b) noexcept { return norm(a.x - b.x, a.y - b.y); }

// Borges and Aldon (2004) with the smaller range, after Dietmayer: the distance, per metre of range, that
// a wall met at the smallest allowed incidence would show between two beams `angle` apart.
double breakpoint_ratio(double angle, double break_angle) noexcept {
  const double incidence = std::max(break_angle, 2.0 * angle);
  return std::sin(angle) / std::sin(incidence - angle);
}

void break_into_sections(const Buffer<ScanPoint>& points, double angle_step, double beam_step,
                         const SegmentationParams& params, Buffer<Section>& sections) noexcept {
  const int gap_limit = static_cast<int>(std::lround(static_cast<double>(params.max_beam_gap) * beam_step));
  const double ratio_of_neighbours = breakpoint_ratio(angle_step, params.break_angle);
  double mean = 2.0 * points[0].range * angle_step;
  sections.push({0, 0});
  for (std::size_t j = 1; j < points.size(); ++j) {
    const ScanPoint& a = points[j - 1];
    const ScanPoint& b = points[j];
    const int beams = b.beam - a.beam;
    const double angle = static_cast<double>(beams) * angle_step;
    const double d = distance(a, b);
    const double floor = std::max(params.break_min, 2.0 * std::min(a.range, b.range) * angle);
    const double sigma = params.range_sigma * (a.range > 10.0 ? 1.7 : 1.0);
    const double ratio = beams == 1 ? ratio_of_neighbours : breakpoint_ratio(angle, params.break_angle);
    const double adaptive = std::min(a.range, b.range) * ratio + 3.0 * sigma;
    const double trend = params.mean_factor * mean * static_cast<double>(beams);
    const double limit = std::clamp(std::max(adaptive, trend), floor, std::max(floor, params.break_max * beam_step));
    const bool is_break = d > limit || beams > gap_limit;
    mean += params.mean_gain * (d / static_cast<double>(beams) - mean);
    if (is_break) {
      mean = 2.0 * b.range * angle_step;
      if (!sections.push({j, j})) return;
    } else {
      sections.back().last = j;
    }
  }
}

void measure(const Buffer<ScanPoint>& points, Section& section) noexcept {
  section.nearest = points[section.first].range;
  for (std::size_t i = section.first; i <= section.last; ++i)
    section.nearest = std::min(section.nearest, points[i].range);
  section.length = distance(points[section.first], points[section.last]);
}

void merge_neighbours(const Buffer<ScanPoint>& points, double merge_distance, Buffer<Section>& sections) noexcept {
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
  if (count < points_needed || section.length < params.min_chord) section.fate = Fate::too_small;
  if (section.nearest > params.max_nearest) section.fate = Fate::too_far;
}

// Whether all sections between i and k lie beyond the gap from the end of i to the start of k.
bool lie_behind_gap(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, std::size_t i,
                    std::size_t k) noexcept {
  const double gap_range = std::min(points[sections[i].last].range, points[sections[k].first].range);
  for (std::size_t between = i + 1; between < k; ++between)
    if (sections[between].fate != Fate::seen_through && sections[between].nearest < gap_range) return false;
  return true;
}

// Pipes leave gaps at their joints, and one sees through them and over low walls. Where the gap between
// two sections is too narrow to drive through, what shows between them is not track. A piece of pipe may
// itself be too small to count; next to a piece that does, it is wall.
void drop_seen_through(const Buffer<ScanPoint>& points, double gap, Buffer<Section>& sections) noexcept {
  constexpr std::size_t reach = 10;  // sections that may show through one gap
  const auto is_solid = [](const Section& s) {
    return s.fate == Fate::kept || (s.fate == Fate::too_small && s.last - s.first >= 2);
  };
  for (std::size_t i = 0; i + 1 < sections.size(); ++i) {
    if (!is_solid(sections[i])) continue;
    const std::size_t end = std::min(sections.size(), i + 2 + reach);
    for (std::size_t k = i + 1; k < end; ++k) {
      if (!is_solid(sections[k])) continue;
      if (distance(points[sections[i].last], points[sections[k].first]) >= gap) continue;
      if (!lie_behind_gap(points, sections, i, k)) continue;
      for (std::size_t between = i + 1; between < k; ++between) sections[between].fate = Fate::seen_through;
      if (sections[i].fate == Fate::kept || sections[k].fate == Fate::kept)
        sections[i].fate = sections[k].fate = Fate::kept;
      break;
    }
  }
}

}  // namespace

double median_beam_step(const Buffer<ScanPoint>& points) noexcept {
  constexpr std::size_t bins = 64;
  std::array<std::size_t, bins> count{};
  if (points.size() < 2) return 1.0;
  for (std::size_t j = 1; j < points.size(); ++j)
    ++count[std::min(bins - 1, static_cast<std::size_t>(points[j].beam - points[j - 1].beam))];
  std::size_t seen = 0;
  for (std::size_t step = 0; step < bins; ++step) {
    seen += count[step];
    if (2 * seen >= points.size() - 1) return static_cast<double>(std::max<std::size_t>(step, 1));
  }
  return 1.0;
}

double passable_gap(double width, const SegmentationParams& params) noexcept {
  return std::clamp(params.pass_ratio * width, params.pass_min, params.pass_max);
}

void segment(const Buffer<ScanPoint>& points, double angle_step, double width, const SegmentationParams& params,
             Buffer<Section>& sections) noexcept {
  sections.clear();
  if (points.empty()) return;
  const double beam_step = median_beam_step(points);
  break_into_sections(points, angle_step, beam_step, params, sections);
  merge_neighbours(points, params.merge_distance, sections);
  for (Section& section : sections) {
    measure(points, section);
    eliminate(params, beam_step, section);
  }
  drop_seen_through(points, passable_gap(width, params), sections);
}

}  // namespace firstlap
