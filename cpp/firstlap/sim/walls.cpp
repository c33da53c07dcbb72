#include "firstlap/sim/walls.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace firstlap::sim {
namespace {

constexpr std::size_t block_edges = 16;
constexpr double max_cells = 1e6;

bool finite(const WallSegment& s) {
  return std::isfinite(s.x1) && std::isfinite(s.y1) && std::isfinite(s.x2) && std::isfinite(s.y2);
}

std::int32_t clamped_cell(double offset, double cell_size, std::int32_t cells) {
  const double cell = std::floor(offset / cell_size);
  if (!(cell > 0.0)) return 0;
  return cell < cells - 1 ? static_cast<std::int32_t>(cell) : cells - 1;
}

}  // namespace

double range_along(Point2 beam, const WallSegment& w) noexcept {
  const double dx = w.x2 - w.x1, dy = w.y2 - w.y1;
  const double across = beam.x * dy - beam.y * dx;
  if (across == 0.0) return std::numeric_limits<double>::infinity();
  const double range = (w.x1 * dy - w.y1 * dx) / across;
  const double share = (w.x1 * beam.y - w.y1 * beam.x) / across;
  const bool hit = range >= 0.0 && share >= 0.0 && share <= 1.0;
  return hit ? range : std::numeric_limits<double>::infinity();
}

double distance(Point2 point, const WallSegment& s) noexcept {
  const double dx = s.x2 - s.x1, dy = s.y2 - s.y1;
  const double px = point.x - s.x1, py = point.y - s.y1;
  const double length_squared = dx * dx + dy * dy;
  const double t = length_squared > 0.0 ? std::clamp((px * dx + py * dy) / length_squared, 0.0, 1.0) : 0.0;
  return std::sqrt((px - t * dx) * (px - t * dx) + (py - t * dy) * (py - t * dy));
}

Walls::Walls(std::vector<WallSegment> segments, double cell_size)
    : segments_(std::move(segments)), cell_size_(cell_size) {
  if (!(cell_size > 0.0)) throw std::invalid_argument("walls.cell_size must be positive");
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    if (!finite(segments_[i])) throw std::invalid_argument("wall segment " + std::to_string(i) + " is not finite");
  }
  if (segments_.empty()) return;
  place_grid();
  build_grid();
  build_visible();
}

void Walls::place_grid() {
  double max_x = segments_[0].x1, max_y = segments_[0].y1;
  origin_x_ = max_x;
  origin_y_ = max_y;
  for (const WallSegment& s : segments_) {
    origin_x_ = std::min({origin_x_, s.x1, s.x2});
    origin_y_ = std::min({origin_y_, s.y1, s.y2});
    max_x = std::max({max_x, s.x1, s.x2});
    max_y = std::max({max_y, s.y1, s.y2});
  }
  const double width = max_x - origin_x_, height = max_y - origin_y_;
  while ((width / cell_size_ + 1.0) * (height / cell_size_ + 1.0) > max_cells) cell_size_ *= 2.0;
  columns_ = static_cast<std::int32_t>(width / cell_size_) + 1;
  rows_ = static_cast<std::int32_t>(height / cell_size_) + 1;
}

Walls::CellRange Walls::cells_of(double min_x, double min_y, double max_x, double max_y) const {
  return {clamped_cell(min_x - origin_x_, cell_size_, columns_), clamped_cell(min_y - origin_y_, cell_size_, rows_),
          clamped_cell(max_x - origin_x_, cell_size_, columns_), clamped_cell(max_y - origin_y_, cell_size_, rows_)};
}

Walls::CellRange Walls::cells_of(const WallSegment& s) const {
  return cells_of(std::min(s.x1, s.x2), std::min(s.y1, s.y2), std::max(s.x1, s.x2), std::max(s.y1, s.y2));
}

bool Walls::covers_all(const CellRange& range) const noexcept {
  return range.x0 <= 0 && range.y0 <= 0 && range.x1 >= columns_ - 1 && range.y1 >= rows_ - 1;
}

// Counting sort of the segments into cells.
void Walls::build_grid() {
  const auto each_cell = [this](const CellRange& range, auto&& visit) {
    for (std::int32_t row = range.y0; row <= range.y1; ++row) {
      for (std::int32_t column = range.x0; column <= range.x1; ++column) {
        visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column));
      }
    }
  };
  cell_start_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const WallSegment& s : segments_) {
    ranges_.push_back(cells_of(s));
    each_cell(ranges_.back(), [this](std::size_t cell) { ++cell_start_[cell + 1]; });
  }
  for (std::size_t i = 1; i < cell_start_.size(); ++i) cell_start_[i] += cell_start_[i - 1];
  cell_items_.resize(cell_start_.back());
  std::vector<std::uint32_t> next(cell_start_.begin(), cell_start_.end() - 1);
  for (std::uint32_t i = 0; i < segments_.size(); ++i) {
    each_cell(ranges_[i], [&](std::size_t cell) { cell_items_[next[cell]++] = i; });
  }
}

void Walls::build_visible() {
  for (const WallSegment& segment : segments_) {
    const bool empty = segment.x1 == segment.x2 && segment.y1 == segment.y2;
    if (segment.visible && !empty) append_visible(segment);
  }
  for (WallBlock& block : visible_.blocks) {
    const auto [min_x, max_x] = std::minmax_element(&visible_.x[block.first], &visible_.x[block.first] + block.count);
    const auto [min_y, max_y] = std::minmax_element(&visible_.y[block.first], &visible_.y[block.first] + block.count);
    block.x = 0.5 * (*min_x + *max_x);
    block.y = 0.5 * (*min_y + *max_y);
    block.radius = 0.5 * std::hypot(*max_x - *min_x, *max_y - *min_y) + 1e-9;
  }
}

// Continues the last block if the segment starts at its end and the block is not full.
void Walls::append_visible(const WallSegment& segment) {
  VisibleWalls& v = visible_;
  const bool joins = !v.x.empty() && v.x.back() == segment.x1 && v.y.back() == segment.y1;
  if (!joins || v.blocks.back().count > block_edges) {
    v.blocks.push_back({v.x.size(), 1});
    v.x.push_back(segment.x1);
    v.y.push_back(segment.y1);
  }
  v.x.push_back(segment.x2);
  v.y.push_back(segment.y2);
  ++v.blocks.back().count;
}

std::size_t Walls::near(Point2 center, double radius, std::span<std::uint32_t> out) const {
  std::size_t count = 0;
  for_each_near(center, radius, [&](std::size_t i) {
    if (distance(center, segments_[i]) > radius) return;
    if (count < out.size()) out[count] = static_cast<std::uint32_t>(i);
    ++count;
  });
  return count;
}

double Walls::nearest_distance(Point2 point) const {
  return nearest_solid(point, 0.0, [&](std::size_t i) { return distance(point, segments_[i]); });
}

double Walls::raycast_brute_force(const Pose2& pose, double angle) const {
  const Point2 beam{std::cos(pose.yaw + angle), std::sin(pose.yaw + angle)};
  double nearest = std::numeric_limits<double>::infinity();
  for (const WallSegment& w : segments_) {
    if (!w.visible) continue;
    nearest = std::min(nearest, range_along(beam, {w.x1 - pose.x, w.y1 - pose.y, w.x2 - pose.x, w.y2 - pose.y}));
  }
  return nearest;
}

}  // namespace firstlap::sim
