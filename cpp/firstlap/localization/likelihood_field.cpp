#include "firstlap/localization/likelihood_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "firstlap/common/geometry.hpp"
#include "firstlap/mapping/occupancy_grid.hpp"

namespace firstlap::localization {
namespace {

constexpr float none = 1e12F;

// Exact squared distance transform of one line: lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012).
class Envelope {
 public:
  explicit Envelope(std::size_t longest) : f_(longest), vertex_(longest), edge_(longest + 1) {}

  // Transforms values[i * step], i < n, in place.
  void run(float* values, std::size_t n, std::size_t step) {
    for (std::size_t i = 0; i < n; ++i) f_[i] = values[i * step];
    std::size_t k = 0;
    vertex_[0] = 0;
    edge_[0] = -none;
    edge_[1] = none;
    for (std::size_t q = 1; q < n; ++q) {
      double s = meet(q, vertex_[k]);
      while (k > 0 && s <= edge_[k]) s = meet(q, vertex_[--k]);
      vertex_[++k] = q;
      edge_[k] = s;
      edge_[k + 1] = none;
    }
    k = 0;
    for (std::size_t q = 0; q < n; ++q) {
      while (edge_[k + 1] < static_cast<double>(q)) ++k;
      const float offset = static_cast<float>(q) - static_cast<float>(vertex_[k]);
      values[q * step] = offset * offset + f_[vertex_[k]];
    }
  }

 private:
  double meet(std::size_t q, std::size_t v) const {
    const auto a = static_cast<double>(q), b = static_cast<double>(v);
    return std::max(-1e11,
                    ((static_cast<double>(f_[q]) + a * a) - (static_cast<double>(f_[v]) + b * b)) / (2.0 * (a - b)));
  }

  std::vector<float> f_;
  std::vector<std::size_t> vertex_;
  std::vector<double> edge_;
};

void check(std::span<const std::uint8_t> occupied, int columns, int rows, double resolution) {
  if (columns < 1 || rows < 1 ||
      occupied.size() != static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) ||
      occupied.size() > mapping::max_grid_cells || !(resolution > 0.0)) {
    throw std::invalid_argument("a map needs columns x rows cells, at most " + std::to_string(mapping::max_grid_cells));
  }
  if (std::all_of(occupied.begin(), occupied.end(), [](std::uint8_t c) { return c == 0; })) {
    throw std::invalid_argument("a map without an occupied cell: localization is not possible");
  }
}

// A pose in the field's frame, with cosine and sine of its heading.
struct Placement {
  float x, y, c, s;
};

// Number of beams of a scan at a pose that end within `limit_mm` of a wall.
int count_fitting(std::span<const Beam> beams, const LikelihoodField& field, const Placement& at,
                  int limit_mm) noexcept {
  const auto [x, y, c, s] = at;
  int fitting = 0;
  for (const Beam& b : beams) fitting += field.distance_mm(x + c * b.x - s * b.y, y + s * b.x + c * b.y) <= limit_mm;
  return fitting;
}

}  // namespace

LikelihoodField::LikelihoodField(std::span<const std::uint8_t> occupied, int columns, int rows, double resolution,
                                 const Pose2& origin)
    : columns_(columns),
      rows_(rows),
      stride_(static_cast<std::size_t>(std::max(columns, 0))),
      resolution_(resolution),
      origin_(origin),
      scale_(static_cast<float>(1.0 / resolution)),
      columns_f_(static_cast<float>(columns)),
      rows_f_(static_cast<float>(rows)) {
  check(occupied, columns, rows, resolution);
  std::vector<float> squared(occupied.size());
  std::transform(occupied.begin(), occupied.end(), squared.begin(), [](std::uint8_t c) { return c ? 0.0F : none; });
  Envelope envelope(std::max(stride_, static_cast<std::size_t>(rows)));
  for (std::size_t r = 0; r < static_cast<std::size_t>(rows); ++r)
    envelope.run(squared.data() + r * stride_, stride_, 1);
  for (std::size_t c = 0; c < stride_; ++c) envelope.run(squared.data() + c, static_cast<std::size_t>(rows), stride_);
  mm_.resize(squared.size());
  const auto mm = static_cast<float>(1000.0 * resolution);
  std::transform(squared.begin(), squared.end(), mm_.begin(), [&](float s) {
    return static_cast<std::uint16_t>(std::min(std::sqrt(s) * mm + 0.5F, static_cast<float>(max_distance_mm)));
  });
}

Pose2 LikelihoodField::to_field(const Pose2& in_map) const noexcept {
  const double c = std::cos(origin_.yaw), s = std::sin(origin_.yaw);
  const double dx = in_map.x - origin_.x, dy = in_map.y - origin_.y;
  return {c * dx + s * dy, -s * dx + c * dy, in_map.yaw - origin_.yaw};
}

Pose2 LikelihoodField::to_map(const Pose2& in_field) const noexcept {
  const double c = std::cos(origin_.yaw), s = std::sin(origin_.yaw);
  return {origin_.x + c * in_field.x - s * in_field.y, origin_.y + s * in_field.x + c * in_field.y,
          wrap_angle(in_field.yaw + origin_.yaw)};
}

LikelihoodField::Slope LikelihoodField::slope(double x, double y) const noexcept {
  const double u = x / resolution_ - 0.5, v = y / resolution_ - 0.5;
  if (!(u >= 0.0 && v >= 0.0 && u < columns_ - 1 && v < rows_ - 1)) return {1e-3 * max_distance_mm, 0.0, 0.0};
  const auto column = static_cast<std::size_t>(u), row = static_cast<std::size_t>(v);
  const double a = u - static_cast<double>(column), b = v - static_cast<double>(row);
  const std::uint16_t* m = mm_.data() + row * stride_ + column;
  const double m00 = m[0], m10 = m[1], m01 = m[stride_], m11 = m[stride_ + 1];
  const double low = m00 + a * (m10 - m00), high = m01 + a * (m11 - m01), scale = 1e-3 / resolution_;
  return {1e-3 * (low + b * (high - low)), scale * ((1.0 - b) * (m10 - m00) + b * (m11 - m01)), scale * (high - low)};
}

LikelihoodField field_of(std::span<const mapping::CloudPoint> points, double resolution) {
  if (points.empty()) throw std::invalid_argument("a field of no points");
  double x0 = 1e300, y0 = 1e300, x1 = -1e300, y1 = -1e300;
  for (const mapping::CloudPoint& p : points) {
    x0 = std::min(x0, p.x);
    y0 = std::min(y0, p.y);
    x1 = std::max(x1, p.x);
    y1 = std::max(y1, p.y);
  }
  const double margin = 10.0 * resolution;
  const int columns = static_cast<int>(std::min((x1 - x0 + 2.0 * margin) / resolution, 1e4)) + 1;
  const int rows = static_cast<int>(std::min((y1 - y0 + 2.0 * margin) / resolution, 1e4)) + 1;
  std::vector<std::uint8_t> occupied(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (const mapping::CloudPoint& p : points) {
    const int column = std::clamp(static_cast<int>((p.x - x0 + margin) / resolution), 0, columns - 1);
    const int row = std::clamp(static_cast<int>((p.y - y0 + margin) / resolution), 0, rows - 1);
    occupied[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] = 1;
  }
  return {occupied, columns, rows, resolution, {x0 - margin, y0 - margin, 0.0}};
}

SearchResult search(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& guess,
                    const SearchWindow& window) noexcept {
  SearchResult best{guess, -1.0};
  if (beams.empty()) return {guess, 0.0};
  const Pose2 from = field.to_field(guess);
  const int steps = static_cast<int>(std::clamp(window.radius / window.step, 0.0, 200.0));
  const int turns = static_cast<int>(std::clamp(window.angle / window.turn, 0.0, 200.0));
  const int limit_mm = static_cast<int>(1000.0 * window.step);
  for (int k = -turns; k <= turns; ++k) {
    const double yaw = from.yaw + k * window.turn;
    const auto c = static_cast<float>(std::cos(yaw)), s = static_cast<float>(std::sin(yaw));
    for (int i = -steps; i <= steps; ++i) {
      for (int j = -steps; j <= steps; ++j) {
        if (i * i + j * j > steps * steps) continue;
        const Pose2 pose{from.x + i * window.step, from.y + j * window.step, yaw};
        const Placement at{static_cast<float>(pose.x), static_cast<float>(pose.y), c, s};
        const int fitting = count_fitting(beams, field, at, limit_mm);
        // Among equal fits, the pose nearest to the guess.
        const double fit = fitting / static_cast<double>(beams.size()) - 1e-6 * (i * i + j * j + k * k);
        if (fit > best.fit) best = {pose, fit};
      }
    }
  }
  return {field.to_map(best.pose), best.fit};
}

}  // namespace firstlap::localization
