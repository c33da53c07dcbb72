#include "firstlap/sim/lidar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

namespace firstlap::sim {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float angle_error = 4e-6F;  // [rad] generous error bound of approximate_atan2
constexpr double max_sector = 1.2;    // [rad] < pi/2, so that two half planes and a front describe the sector

// Vectorizable; error at most 1e-6 rad.
inline float approximate_atan2(float y, float x) {
  const float ax = std::fabs(x), ay = std::fabs(y);
  const float longer = ax > ay ? ax : ay, shorter = ax > ay ? ay : ax;
  const float t = shorter / (longer + 1e-30F), z = t * t;
  float p = -0.00405456F;
  p = p * z + 0.02186293F;
  p = p * z - 0.05591229F;
  p = p * z + 0.09642195F;
  p = p * z - 0.13908629F;
  p = p * z + 0.19946566F;
  p = p * z - 0.33329861F;
  p = p * z + 0.99999934F;
  const float octant = p * t;
  const float quadrant = (ay > ax ? 0.5F * pi : 0.0F) + std::copysign(octant, ax - ay);
  const float half = (x < 0.0F ? pi : 0.0F) + std::copysign(quadrant, x);
  return std::copysign(half, y + 0.0F);  // -0 counts as 0
}

inline int ceiling(float value) {
  const int truncated = static_cast<int>(value);
  return truncated + static_cast<int>(value > static_cast<float>(truncated));
}

// Positive if the beam (c, s) is counterclockwise of the point (x, y).
inline double side(double x, double y, double c, double s) { return x * s - y * c; }

// Transforms map points into the frame of the middle of the scan, whose heading is (c, s).
void rotate(const double* __restrict map_x, const double* __restrict map_y, const Pose2& laser, double c, double s,
            double* __restrict x, double* __restrict y, std::size_t count) {
  const double laser_x = laser.x, laser_y = laser.y;
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = map_x[i] - laser_x, dy = map_y[i] - laser_y;
    x[i] = c * dx + s * dy;
    y[i] = c * dy - s * dx;
  }
}

void keep_nearest(double* __restrict inverse, const double* __restrict c, const double* __restrict s, double px,
                  double py, int count) {
  for (int i = 0; i < count; ++i) {
    const double value = px * c[i] + py * s[i];
    inverse[i] = value > inverse[i] ? value : inverse[i];
  }
}

// Checks every field, and combinations of fields.
void check(const LidarParams& params) {
  constexpr double rounding = 1e-6;  // [s] allows for rounded periods in files
  validate(params, "lidar");
  if (params.beams - params.beams_vary < 2) {
    throw std::invalid_argument("lidar.beams_vary is " + std::to_string(params.beams_vary) +
                                ", allowed at most lidar.beams - 2, which is " + std::to_string(params.beams - 2));
  }
  if (params.sweep_time > 1.0 / params.rate + rounding) {
    throw std::invalid_argument("lidar.sweep_time is " + plain(params.sweep_time) +
                                ", allowed at most one scan period, 1 / lidar.rate, which is " +
                                plain(1.0 / params.rate) + " s");
  }
}

}  // namespace

Lidar::Lidar(const LidarParams& params, const Walls& walls)
    : params_(params), max_beams_(params.beams), walls_(&walls) {
  check(params);
  set_beams(params.beams);
  const std::size_t vertices = walls.visible().x.size();
  x_.resize(vertices);
  y_.resize(vertices);
  beam_.resize(vertices);
  last_doubtful_.resize(vertices);
  counts_.reserve(walls.visible().blocks.size());
}

void Lidar::set_beams(int beams) {
  params_.beams = beams;
  const auto count = static_cast<std::size_t>(beams);
  cos_.resize(count);
  sin_.resize(count);
  inverse_range_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = -0.5 * params_.fov + static_cast<double>(i) * params_.beam_step();
    cos_[i] = std::cos(angle);
    sin_[i] = std::sin(angle);
  }
}

void Lidar::begin_scan(Rng& rng, std::vector<float>& ranges) {
  if (params_.beams_vary > 0) {
    const int fewer = static_cast<int>(rng.uniform() * (params_.beams_vary + 1));
    set_beams(max_beams_ - std::min(fewer, params_.beams_vary));
  }
  ranges.resize(static_cast<std::size_t>(params_.beams));
}

void Lidar::scan(const Pose2& laser, std::span<float> out) { scan_sector(laser, 0, params_.beams, out); }

void Lidar::scan_sector(const Pose2& laser, int first, int last, std::span<float> out) {
  first = std::max(first, 0);
  last = std::min({last, params_.beams, static_cast<int>(out.size())});
  if (first >= last) return;
  if (params_.turns_right()) std::tie(first, last) = std::pair{params_.beams - last, params_.beams - first};
  const Pose2 middle{laser.x, laser.y, laser.yaw + params_.middle()};
  const double angle = (last - first) * params_.beam_step();
  const int wedges = std::min(static_cast<int>(std::ceil(angle / max_sector)), last - first);
  for (int i = 0; i < wedges; ++i) {
    cast_sector(middle, first + (last - first) * i / wedges, first + (last - first) * (i + 1) / wedges, out);
  }
}

void Lidar::cast_sector(const Pose2& laser, int first, int last, std::span<float> out) {
  std::fill(inverse_range_.begin() + first, inverse_range_.begin() + last, 0.0);
  const std::size_t vertices = gather(laser, first, last);
  index_vertices(vertices);
  settle_indices(vertices);
  std::size_t at = 0;
  for (const std::size_t count : counts_) {
    draw_block(at, count, first, last);
    at += count;
  }
  write_ranges(first, last, out);
}

// Gathers the blocks whose bounding circle intersects the sector of beams [first, last), in the LiDAR's frame. Returns
// the number of their vertices.
std::size_t Lidar::gather(const Pose2& laser, int first, int last) {
  const VisibleWalls& walls = walls_->visible();
  const double c = std::cos(laser.yaw), s = std::sin(laser.yaw);
  const auto right = static_cast<std::size_t>(first), left = static_cast<std::size_t>(last - 1);
  const std::size_t middle = (right + left) / 2;
  std::size_t vertices = 0;
  counts_.clear();
  for (const WallBlock& block : walls.blocks) {
    const double dx = block.x - laser.x, dy = block.y - laser.y;
    const double x = c * dx + s * dy, y = c * dy - s * dx, far = params_.range_max + block.radius;
    const bool outside = side(x, y, cos_[right], sin_[right]) > block.radius ||
                         side(x, y, cos_[left], sin_[left]) < -block.radius ||
                         x * cos_[middle] + y * sin_[middle] < -block.radius || x * x + y * y > far * far;
    if (outside) continue;
    rotate(&walls.x[block.first], &walls.y[block.first], laser, c, s, &x_[vertices], &y_[vertices], block.count);
    vertices += block.count;
    counts_.push_back(block.count);
  }
  return vertices;
}

// For each vertex a range of beams that contains the first beam at or after it, mostly only that one.
void Lidar::index_vertices(std::size_t count) {
  const auto angle_min = static_cast<float>(-0.5 * params_.fov);
  const auto per_radian = static_cast<float>(1.0 / params_.beam_step());
  const float margin = angle_error * per_radian + 1e-3F;
  const double* x = x_.data();
  const double* y = y_.data();
  int* low = beam_.data();
  int* high = last_doubtful_.data();
  for (std::size_t i = 0; i < count; ++i) {
    const float angle = approximate_atan2(static_cast<float>(y[i]), static_cast<float>(x[i]));
    const float index = (angle - angle_min) * per_radian;
    low[i] = ceiling(index - margin);
    high[i] = ceiling(index + margin);
  }
}

// Resolves doubtful vertices with the exact side of the beam, so that adjacent edges leave no gap.
void Lidar::settle_indices(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    int beam = beam_[i];
    if (beam == last_doubtful_[i]) continue;
    for (; beam < last_doubtful_[i]; ++beam) {
      if (beam < 0 || beam >= params_.beams) continue;
      const auto b = static_cast<std::size_t>(beam);
      if (side(x_[i], y_[i], cos_[b], sin_[b]) >= 0.0) break;
    }
    beam_[i] = beam;
  }
}

// Every edge covers the beams from its clockwise end up to, but not including, the beam of its other end.
void Lidar::draw_block(std::size_t begin, std::size_t count, int first, int last) {
  for (std::size_t i = begin; i + 1 < begin + count; ++i) {
    const double cross = x_[i] * y_[i + 1] - y_[i] * x_[i + 1];
    if (cross == 0.0) continue;  // edge-on
    const std::size_t right = cross > 0.0 ? i : i + 1, left = cross > 0.0 ? i + 1 : i;
    const int from = beam_[right], to = beam_[left];
    const bool passes_behind = y_[right] >= 0.0 && y_[left] < 0.0;
    const auto draw = [&](int low, int high) {
      if (low >= high) return;
      const double px = (y_[i + 1] - y_[i]) / cross, py = (x_[i] - x_[i + 1]) / cross;
      keep_nearest(&inverse_range_[static_cast<std::size_t>(low)], &cos_[static_cast<std::size_t>(low)],
                   &sin_[static_cast<std::size_t>(low)], px, py, high - low);
    };
    draw(std::max(from, first), passes_behind ? last : std::min(to, last));
    if (passes_behind) draw(first, std::min(to, last));
  }
}

void Lidar::write_ranges(int first, int last, std::span<float> out) const {
  const double* inverse = inverse_range_.data();
  const auto range_min = static_cast<float>(params_.range_min), range_max = static_cast<float>(params_.range_max);
  const auto scale = static_cast<float>(params_.range_scale);
  // Scan index of internal beam 0, and the step to the next.
  const int begin = params_.turns_right() ? params_.beams - 1 : 0, step = params_.turns_right() ? -1 : 1;
  float* ranges = out.data();
  for (int i = first; i < last; ++i) {
    const auto range = scale * static_cast<float>(1.0 / inverse[i]);
    const float near_checked = range < range_min ? -inf : range;
    ranges[begin + step * i] = range > range_max ? inf : near_checked;
  }
}

void Lidar::add_noise(std::span<float> ranges, Rng& rng) const {
  if (static_cast<NoReturn>(params_.no_return) == NoReturn::range_max)
    std::replace(ranges.begin(), ranges.end(), inf, static_cast<float>(params_.range_max));
  if (params_.noise_sigma > 0.0) {
    for (float& range : ranges) {
      const auto noisy = range + static_cast<float>(params_.noise_sigma * rng.gaussian());
      range = noisy > 0.0F || range < 0.0F ? noisy : 0.0F;
    }
  }
  if (params_.dropout_rate > 0.0) {  // the gaps between lost beams follow a geometric distribution
    const double log_kept = std::log1p(-params_.dropout_rate);
    const auto gap = [&] { return std::min(std::log1p(-rng.uniform()) / log_kept, 1e6); };
    for (auto i = static_cast<std::size_t>(gap()); i < ranges.size(); i += 1 + static_cast<std::size_t>(gap())) {
      ranges[i] = inf;
    }
  }
  if (rng.uniform() < params_.dropout_block_rate && !ranges.empty()) {
    const auto begin = static_cast<std::size_t>(rng.uniform() * static_cast<double>(ranges.size()));
    const auto length = std::min(static_cast<std::size_t>(params_.dropout_block_beams), ranges.size() - begin);
    std::fill_n(ranges.begin() + static_cast<std::ptrdiff_t>(begin), length, inf);
  }
  if (params_.dropout_block_share > 0.0 && params_.dropout_block_beams > 0) drop_blocks(ranges, rng);
  if (static_cast<NoReturn>(params_.no_return) == NoReturn::nan) std::replace(ranges.begin(), ranges.end(), inf, nan);
  if (static_cast<NoReturn>(params_.no_return) == NoReturn::zero) std::replace(ranges.begin(), ranges.end(), inf, 0.0F);
}

// Alternating lost blocks and runs of kept beams. The lengths of the runs are exponential, with the mean that gives the
// share; the scan starts at a random place in the first block or run, so that all angles are lost equally often.
void Lidar::drop_blocks(std::span<float> ranges, Rng& rng) const {
  const double block = params_.dropout_block_beams, share = params_.dropout_block_share;
  const double mean_run = block * (1.0 - share) / share;
  const auto run = [&] { return -mean_run * std::log1p(-rng.uniform()); };
  const bool begins_lost = rng.uniform() < share;
  const double end = static_cast<double>(ranges.size());
  double lost_from = begins_lost ? -block * rng.uniform() : run();
  while (lost_from < end) {
    const auto first = static_cast<std::size_t>(std::max(0.0, std::round(lost_from)));
    const auto last = static_cast<std::size_t>(std::clamp(std::round(lost_from + block), 0.0, end));
    for (std::size_t i = first; i < last; ++i) ranges[i] = inf;
    lost_from += block + run();
  }
}

LaserScan Lidar::view(std::span<const float> ranges) const noexcept {
  LidarParams params = params_;
  params.beams = static_cast<int>(ranges.size());
  return {.angle_min = params.angle_min(),
          .angle_increment = params.angle_increment(),
          .time_increment = params.sweep_time / (params.beams - 1),
          .range_min = params_.range_min,
          .range_max = params_.range_max,
          .ranges = ranges};
}

}  // namespace firstlap::sim
