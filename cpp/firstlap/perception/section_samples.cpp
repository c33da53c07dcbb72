#include "firstlap/perception/section_samples.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

constexpr int max_pieces = 40;  // between two means: bounds the work
constexpr std::size_t around_middle =
    3;                                  // points to either side of the nearest point that are averaged into its sample
constexpr std::size_t path_stride = 2;  // every other point of the previous path is close enough

// Mean of the points of one spacing.
class Bin {
 public:
  void add(const ScanPoint& p) noexcept {
    x_ += p.x;
    y_ += p.y;
    count_ += 1.0;
  }
  [[nodiscard]] Point2 mean() const noexcept { return {x_ / count_, y_ / count_}; }

 private:
  double x_ = 0.0;
  double y_ = 0.0;
  double count_ = 0.0;
};

// Samples one section, `spacing` [m] apart.
class SectionSampler {
 public:
  SectionSampler(const Buffer<ScanPoint>& points, std::size_t section, double spacing,
                 Buffer<SectionSample>& samples) noexcept
      : points_(points), section_(section), spacing_(spacing), samples_(samples) {}

  // Samples outward from the point nearest to the car, so that a mirrored scan gives mirrored samples.
  void sample(const Section& section) noexcept {
    const std::size_t middle = section.middle;
    Bin around;
    const std::size_t reach = std::min({around_middle, middle - section.first, section.last - middle});
    for (std::size_t i = middle - reach; i <= middle + reach; ++i) around.add(points_[i]);
    const Point2 start = around.mean();
    const std::size_t before = samples_.size();
    sample_run(middle, section.first, start);
    std::reverse(samples_.begin() + before, samples_.end());
    samples_.push({.x = start.x, .y = start.y, .section = section_});
    sample_run(middle, section.last, start);
  }

 private:
  // Samples from point `from` to point `to` (in either direction), after the sample `previous`.
  void sample_run(std::size_t from, std::size_t to, Point2 previous) noexcept {
    const std::ptrdiff_t step = to >= from ? 1 : -1;
    Point2 start{points_[from].x, points_[from].y};
    Bin bin;
    bool filled = false;
    for (std::size_t i = from; i != to;) {
      i = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(i) + step);
      bin.add(points_[i]);
      filled = true;
      const double dx = points_[i].x - start.x;
      const double dy = points_[i].y - start.y;
      if (dx * dx + dy * dy < spacing_ * spacing_) continue;
      const Point2 mean = bin.mean();
      push_between(previous, mean);
      previous = mean;
      start = {points_[i].x, points_[i].y};
      bin = {};
      filled = false;
    }
    if (filled) push_between(previous, {points_[to].x, points_[to].y});
  }

  void push_between(Point2 a, Point2 b) noexcept {
    const double d = norm(b.x - a.x, b.y - a.y);
    const int pieces = std::clamp(static_cast<int>(d / spacing_), 1, max_pieces);
    for (int k = 1; k <= pieces; ++k) {
      const double t = static_cast<double>(k) / static_cast<double>(pieces);
      samples_.push({.x = a.x + t * (b.x - a.x), .y = a.y + t * (b.y - a.y), .section = section_});
    }
  }

  const Buffer<ScanPoint>& points_;
  std::size_t section_;
  double spacing_;
  Buffer<SectionSample>& samples_;
};

// +1 if (x, y) lies left of a path or trail, -1 if right of it, 0 if farther away than `radius` or at its ends. Uses
// every `stride`-th point.
template <class Points>
int side_of_way(const Points& path, std::size_t stride, double x, double y, double radius) noexcept {
  double best = radius * radius;
  decltype(&path.front()) nearest = nullptr;
  for (std::size_t i = 0; i < path.size(); i += stride) {
    const double dx = x - path[i].x;
    const double dy = y - path[i].y;
    const double d = dx * dx + dy * dy;
    if (d < best) {
      best = d;
      nearest = &path[i];
    }
  }
  if (nearest == nullptr || nearest == &path.front() || nearest == &path.back()) return 0;
  const double cross = std::cos(nearest->yaw) * (y - nearest->y) - std::sin(nearest->yaw) * (x - nearest->x);
  return cross > 0.0 ? 1 : -1;
}

// The line of sight past an end of a section, if the next beam beyond it is much longer. It runs along that beam, since
// beams in between may be missing.
Sight sight_past(const ScanPoint& end, const ScanPoint& beyond, const CarGeometry& car,
                 const SegmentationParams& params, double shadow) noexcept {
  if (beyond.range < end.range + params.sight_step) return {};
  const double ex = end.x - car.laser_x;
  const double ey = end.y - car.laser_y;
  const double bx = beyond.x - car.laser_x;
  const double by = beyond.y - car.laser_y;
  const double length = norm(bx, by);
  if (ex * bx + ey * by < params.sight_cos * length * norm(ex, ey)) return {};
  return {static_cast<float>(bx / length), static_cast<float>(by / length), static_cast<float>(shadow), false};
}

}  // namespace

void sample_sections(const Buffer<ScanPoint>& points, const Buffer<Section>& sections, const CarGeometry& car,
                     double spacing, const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept {
  const auto enough = static_cast<std::size_t>(params.small_points);
  samples.clear();
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const Section& section = sections[i];
    const bool small_but_real =
        section.status == SectionStatus::too_small && section.last - section.first + 1 >= enough;
    if (section.status != SectionStatus::kept && !small_but_real) continue;
    const std::size_t before = samples.size();
    SectionSampler(points, i, spacing, samples).sample(section);
    if (samples.size() == before) return;
    if (section.first > 0)
      samples[before].sight = sight_past(points[section.first], points[section.first - 1], car, params, 1.0);
    if (section.last + 1 < points.size())
      samples.back().sight = sight_past(points[section.last], points[section.last + 1], car, params, -1.0);
  }
}

void label_from_history(const LocalWalls& before, const Buffer<TrajectoryPoint>& path, const Buffer<TrailPoint>& trail,
                        const SegmentationParams& params, Buffer<SectionSample>& samples) noexcept {
  const double same_wall = params.past_same;
  WallSearch left(before.left, before.left.size());
  WallSearch right(before.right, before.right.size());
  for (SectionSample& sample : samples) {
    // Most samples keep their side; then the other side need not be searched.
    const bool ask_left_first = sample.y > 0.0;
    WallSearch& likely = ask_left_first ? left : right;
    WallSearch& other = ask_left_first ? right : left;
    const double first = likely.distance(sample.x, sample.y, same_wall);
    const double second = first < same_wall ? 2.0 * same_wall : other.distance(sample.x, sample.y, same_wall);
    if (std::min(first, second) < params.past_radius)
      sample.vote = (first < second) == ask_left_first ? 1 : -1;
    else
      sample.vote = side_of_way(path, path_stride, sample.x, sample.y, params.path_radius);
    if (sample.vote == 0) sample.vote = side_of_way(trail, 1, sample.x, sample.y, params.path_radius);
  }
}

}  // namespace firstlap
