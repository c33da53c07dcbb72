#include "firstlap/perception/sides.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

std::size_t first_kept(const Buffer<Section>& sections) noexcept {
  std::size_t i = 0;
  while (i < sections.size() && sections[i].status != SectionStatus::kept) ++i;
  return i;
}

// Direction of a section at its point `end`, over the length `stretch` [m], as a unit vector out of the section.
Point2 direction_at(const ScanPoint* end, const ScanPoint* stop, std::ptrdiff_t inwards, double stretch) noexcept {
  const ScanPoint* inner = end;
  double d = 0.0;
  while (inner != stop && d < stretch) {
    inner += inwards;
    d = norm(end->x - inner->x, end->y - inner->y);
  }
  return d > 1e-6 ? Point2{(end->x - inner->x) / d, (end->y - inner->y) / d} : Point2{};
}

// Whether the gap between two sections is a hole in one wall: its edges point at each other and nothing is visible
// beyond. The track continues between two walls, never through one.
bool is_hole(const ScanPoint& from, const ScanPoint& to, Point2 out_of_from, Point2 out_of_to,
             double in_line) noexcept {
  const double d = norm(to.x - from.x, to.y - from.y);
  const double cx = (to.x - from.x) / d;
  const double cy = (to.y - from.y) / d;
  return out_of_from.x * cx + out_of_from.y * cy > in_line && -out_of_to.x * cx - out_of_to.y * cy > in_line;
}

bool is_hole(const Buffer<ScanPoint>& points, const Section& a, const Section& b,
             const SegmentationParams& params) noexcept {
  const double edge = std::max(points[a.last].range, points[b.first].range);
  for (std::size_t i = a.last + 1; i < b.first; ++i)
    if (points[i].range > edge + params.hole_beyond) return false;
  return is_hole(points[a.last], points[b.first],
                 direction_at(&points[a.last], &points[a.first], -1, params.hole_stretch),
                 direction_at(&points[b.first], &points[b.last], 1, params.hole_stretch), params.hole_cos);
}

void insert_candidate(SplitCandidate candidate, std::size_t most, Candidates& best) noexcept {
  std::size_t at = best.count;
  while (at > 0 && best.items[at - 1].score < candidate.score) --at;
  if (at >= most) return;
  best.count = std::min(best.count + 1, most);
  for (std::size_t i = best.count - 1; i > at; --i) best.items[i] = best.items[i - 1];
  best.items[at] = candidate;
}

// Ranks the splits of a scan by depth and by the sides that its samples had in earlier scans. Sections are passed in
// scan order: at the first split all sections are left, and those passed are right.
class SplitRanking {
 public:
  SplitRanking(const Buffer<SectionSample>& samples, const SegmentationParams& params) noexcept
      : samples_(samples), params_(params) {
    for (const SectionSample& sample : samples) {
      votes_ += std::abs(sample.vote);
      wrong_ += sample.vote < 0 ? 1.0 : 0.0;
    }
  }

  void consider(std::size_t split, double depth) noexcept {
    const double share = votes_ > 0.0 ? wrong_ / votes_ : 0.0;
    const double trust = std::min(1.0, votes_ / params_.past_samples);
    const double factor = 1.0 - params_.past_weight * trust * std::min(1.0, params_.past_gain * share);
    insert_candidate({split, depth * factor}, static_cast<std::size_t>(params_.split_candidates), best_);
  }

  void pass(std::size_t section) noexcept {
    for (; next_ < samples_.size() && samples_[next_].section <= section; ++next_) wrong_ += samples_[next_].vote;
  }

  [[nodiscard]] const Candidates& best() const noexcept { return best_; }
  [[nodiscard]] bool knows_sides() const noexcept { return votes_ > 0.0; }

 private:
  const Buffer<SectionSample>& samples_;
  const SegmentationParams& params_;
  Candidates best_;
  std::size_t next_ = 0;  // first sample not yet passed
  double votes_ = 0.0;    // labels of all samples
  double wrong_ = 0.0;    // labels that contradict the current split
};

// [m] Depth of the gap between two sections; none if it is too narrow for the car.
std::optional<double> depth_between(const Buffer<ScanPoint>& points, const Section& before, const Section& after,
                                    double width, const SegmentationParams& params) noexcept {
  const ScanPoint& a = points[before.last];
  const ScanPoint& b = points[after.first];
  const double gap = norm(b.x - a.x, b.y - a.y);
  if (gap < passable_gap(width, params)) return std::nullopt;
  // The track ahead is about as wide as before.
  const double fit = std::min(1.0, gap / (params.fit_share * width));
  const double depth = std::max(a.range, b.range) * fit;
  return is_hole(points, before, after, params) ? params.hole_score * depth : depth;
}

// Mean direction of the wall before its visible end, as a unit vector into the occluded area.
Point2 outward_at(const Buffer<SectionSample>& samples, std::size_t end, std::size_t inner) noexcept {
  const double dx = samples[end].x - samples[inner].x;
  const double dy = samples[end].y - samples[inner].y;
  const double d = norm(dx, dy);
  return d > 1e-6 ? Point2{dx / d, dy / d} : Point2{};
}

struct SampleRange {
  std::size_t first = 0;
  std::size_t last = 0;  // inclusive
  double nearest = 0.0;  // [m] from the LiDAR
};

// The sample ranges of one side in scan order, with their weights as anchor.
class SideRanges {
 public:
  void push(SampleRange range, double weight) noexcept {
    if (count_ == max_sections) return;
    ranges_[count_] = range;
    weights_[count_++] = weight;
  }
  [[nodiscard]] std::span<const SampleRange> ranges() const noexcept { return {ranges_.data(), count_}; }
  [[nodiscard]] std::span<const double> weights() const noexcept { return {weights_.data(), count_}; }

 private:
  std::array<SampleRange, max_sections> ranges_;
  std::array<double, max_sections> weights_;
  std::size_t count_ = 0;
};

double gap_between(const Buffer<SectionSample>& samples, const SampleRange& a, const SampleRange& b) noexcept {
  return norm(samples[b.first].x - samples[a.last].x, samples[b.first].y - samples[a.last].y);
}

// Which ends of a sample range are visible ends of the wall.
struct OpenEnds {
  bool before = true;
  bool after = true;
};

// `reach`: number of samples over which the direction at an open end is measured.
void push_range(const Buffer<SectionSample>& samples, const SampleRange& range, OpenEnds open, std::size_t reach,
                WallSide& side) noexcept {
  for (std::size_t i = range.first; i <= range.last; ++i) {
    Point2 out{};
    if (i == range.first && open.before) out = outward_at(samples, i, std::min(range.last, i + reach));
    if (i == range.last && open.after) out = outward_at(samples, i, i >= range.first + reach ? i - reach : range.first);
    side.push(samples[i].x, samples[i].y, out, 0.0F, samples[i].sight);
  }
}

void push_bridge(const Buffer<SectionSample>& samples, const SampleRange& a, const SampleRange& b, double spacing,
                 WallSide& side) noexcept {
  const SectionSample& p = samples[a.last];
  const SectionSample& q = samples[b.first];
  const int pieces = static_cast<int>(norm(q.x - p.x, q.y - p.y) / spacing);
  for (int k = 1; k <= pieces; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(pieces + 1);
    side.push(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), {}, 0.0F);
  }
}

// Sections before `right` and after `left` lie past the end of the right and the left wall beside the car, as after a
// hairpin: they may belong to the other wall.
struct PastEnds {
  std::size_t right = 0;
  std::size_t left = max_sections;

  [[nodiscard]] bool contains(std::size_t section) const noexcept { return section < right || section > left; }
};

PastEnds find_past_ends(const SegmentedScan& scan, const CarGeometry& car, std::size_t split,
                        const SegmentationParams& params) noexcept {
  const double beside = car.laser_x + params.end_beside;
  PastEnds past;
  std::size_t before = scan.sections.size();
  for (std::size_t i = 0; i < scan.sections.size(); ++i) {
    if (scan.sections[i].status != SectionStatus::kept) continue;
    if (before < i) {
      const ScanPoint& end = scan.points[scan.sections[before].last];
      const ScanPoint& start = scan.points[scan.sections[i].first];
      if (i < split && end.range > start.range + params.end_step && start.x < beside) past.right = i;
      if (before >= split && start.range > end.range + params.end_step && end.x < beside)
        past.left = std::min(past.left, before);
    }
    before = i;
  }
  return past;
}

// Parameters for joining the ranges of one side.
struct Chain {
  double spacing;           // [m] of the samples that bridge a gap
  double bridge;            // [m] narrower gaps are bridged
  double gap;               // [m] wider gaps end the side
  std::size_t end_samples;  // over which the direction at a visible end is measured
};

// The ranges of one side, in scan order, that are connected to the anchor. Ranges near the car are always included.
void build_side(const Buffer<SectionSample>& samples, std::span<const SampleRange> ranges,
                std::span<const double> weight, const Chain& chain, WallSide& side) noexcept {
  side.clear();
  if (ranges.empty()) return;
  std::size_t anchor = 0;
  for (std::size_t i = 1; i < ranges.size(); ++i)
    if (weight[i] > weight[anchor]) anchor = i;
  std::size_t first = anchor;
  std::size_t last = anchor;
  const auto hangs_on = [&](const SampleRange& next, double gap) {
    return gap < chain.gap || next.nearest < chain.gap;
  };
  while (first > 0 && hangs_on(ranges[first - 1], gap_between(samples, ranges[first - 1], ranges[first]))) --first;
  while (last + 1 < ranges.size() && hangs_on(ranges[last + 1], gap_between(samples, ranges[last], ranges[last + 1])))
    ++last;
  OpenEnds open;
  for (std::size_t i = first; i <= last; ++i) {
    const bool bridged = i < last && gap_between(samples, ranges[i], ranges[i + 1]) < chain.bridge;
    open.after = !bridged;
    push_range(samples, ranges[i], open, chain.end_samples, side);
    if (bridged) push_bridge(samples, ranges[i], ranges[i + 1], chain.spacing, side);
    open.before = !bridged;
  }
}

// If both walls next to the split are completely visible, the track continues between their ends.
void mark_continuation(const Buffer<Section>& sections, const Buffer<SectionSample>& samples, std::size_t split,
                       LocalWalls& walls) noexcept {
  const SectionSample* last_right = nullptr;
  const SectionSample* first_left = nullptr;
  for (const SectionSample& sample : samples) {
    if (sections[sample.section].status != SectionStatus::kept) continue;
    if (sample.section < split) last_right = &sample;
    if (sample.section >= split && first_left == nullptr) first_left = &sample;
  }
  const std::size_t from = last_right != nullptr ? last_right->section + 1 : 0;
  const std::size_t to = first_left != nullptr ? first_left->section : sections.size();
  for (std::size_t i = from; i < to; ++i)
    if (sections[i].status == SectionStatus::too_far) return;
  const auto is_at = [](const WallSide& side, std::size_t i, const SectionSample& sample) {
    return side.x[i] == static_cast<float>(sample.x) && side.y[i] == static_cast<float>(sample.y);
  };
  if (last_right != nullptr && walls.right.size() > 0 && is_at(walls.right, walls.right.size() - 1, *last_right))
    walls.right.sight[walls.right.size() - 1].track_continues = true;
  if (first_left != nullptr && walls.left.size() > 0 && is_at(walls.left, 0, *first_left))
    walls.left.sight[0].track_continues = true;
}

}  // namespace

Candidates rank_splits(const SegmentedScan& scan, double width, const SegmentationParams& params) noexcept {
  const auto& [points, sections, samples] = scan;
  const std::size_t first = first_kept(sections);
  if (first == sections.size()) return {};
  SplitRanking ranking(samples, params);
  const ScanPoint& start = points[sections[first].first];
  if (start.y > 0.0 || ranking.knows_sides()) ranking.consider(first, params.one_sided_score * start.range);
  const Section* before = &sections[first];
  ranking.pass(first);
  for (std::size_t i = first + 1; i < sections.size(); ++i) {
    if (sections[i].status == SectionStatus::kept) {
      if (const auto depth = depth_between(points, *before, sections[i], width, params)) ranking.consider(i, *depth);
      before = &sections[i];
    }
    ranking.pass(i);
  }
  const ScanPoint& end = points[before->last];
  // A single wall that surrounds the car belongs to the side where it starts.
  if (end.y < 0.0 || ranking.knows_sides() || ranking.best().count == 0)
    ranking.consider(sections.size(), params.one_sided_score * end.range);
  return ranking.best();
}

void split_into_sides(const SegmentedScan& scan, const Split& split, const CarGeometry& car,
                      const SegmentationParams& params, LocalWalls& walls) noexcept {
  const Buffer<Section>& sections = scan.sections;
  const Buffer<SectionSample>& samples = scan.samples;
  SideRanges right;
  SideRanges left;
  const PastEnds past_ends = find_past_ends(scan, car, split.at, params);
  const Chain chain{split.spacing, passable_gap(split.width, params), params.chain_gap,
                    static_cast<std::size_t>(params.end_samples)};
  for (std::size_t i = 0; i < samples.size();) {
    const std::size_t index = samples[i].section;
    SampleRange range{i, i, sections[index].nearest};
    int votes = samples[i].vote;
    while (range.last + 1 < samples.size() && samples[range.last + 1].section == index)
      votes += samples[++range.last].vote;
    const Section& section = sections[index];
    const bool small = section.status != SectionStatus::kept;
    // A small section has no influence on the split, but keeps its previous side. So does what lies past a wall's end;
    // without a previous side it has none.
    i = range.last + 1;
    const bool past = past_ends.contains(index);
    if (past && votes == 0) continue;
    const bool is_right = (small && votes != 0) || past ? votes < 0 : index < split.at;
    (is_right ? right : left).push(range, small ? 0.0 : section.length / std::max(0.1, section.nearest));
  }
  build_side(samples, right.ranges(), right.weights(), chain, walls.right);
  build_side(samples, left.ranges(), left.weights(), chain, walls.left);
  mark_continuation(sections, samples, split.at, walls);
}

}  // namespace firstlap
