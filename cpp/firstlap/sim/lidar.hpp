// An exact planar LiDAR without ray marching: a depth buffer over the beam index. Along a wall 1/r is linear
// in (cos, sin) of the beam angle, 1/r = (n . u) / (n . a) with n the wall's normal, a a point on it and u the
// beam's direction, so the nearest wall of each beam is the largest 1/r.
#pragma once

#include <cstddef>
#include <span>
#include <tuple>
#include <vector>

#include "firstlap/field.hpp"
#include "firstlap/sim/rng.hpp"
#include "firstlap/sim/walls.hpp"
#include "firstlap/types.hpp"

namespace firstlap::sim {

// Defaults: Hokuyo UTM-30LX.
struct LidarParams {
  int beams = 1081;
  double fov = 4.7123889804;
  double rate = 40.0;
  double range_min = 0.06;
  double range_max = 30.0;
  double sweep_time = 0.01875;
  double noise_sigma = 0.01;
  double dropout_rate = 0.002;
  double dropout_block_rate = 0.0;
  int dropout_block_beams = 20;
  double dropout_block_share = 0.0;

  static constexpr auto fields() {
    using P = LidarParams;
    return std::tuple{
        Field{"beams", &P::beams, "", 2.0, 10000.0, "beams of a scan"},
        Field{"fov", &P::fov, "rad", 0.1, 6.28, "angle from the first beam to the last, centred ahead"},
        Field{"rate", &P::rate, "Hz", 5.0, 200.0, "scans per second"},
        Field{"range_min", &P::range_min, "m", 0.0, 1.0, "nearer walls give -inf (REP 117)"},
        Field{"range_max", &P::range_max, "m", 1.0, 200.0, "farther walls give +inf (REP 117)"},
        Field{"sweep_time", &P::sweep_time, "s", 0.0, 0.2, "first beam to last; at most one scan period"},
        Field{"noise_sigma", &P::noise_sigma, "m", 0.0, 0.5, "standard deviation of a range"},
        Field{"dropout_rate", &P::dropout_rate, "", 0.0, 1.0, "share of single beams lost (+inf)"},
        Field{"dropout_block_rate", &P::dropout_block_rate, "", 0.0, 1.0, "share of scans that lose a block"},
        Field{"dropout_block_beams", &P::dropout_block_beams, "", 0.0, 10000.0, "neighbouring beams of a lost block"},
        Field{"dropout_block_share", &P::dropout_block_share, "", 0.0, 0.95, "share of beams lost in such blocks"},
    };
  }

  double angle_min() const noexcept { return -0.5 * fov; }               // [rad]
  double angle_increment() const noexcept { return fov / (beams - 1); }  // [rad]
};

class Lidar {
 public:
  // Keeps a reference to `walls`. Throws std::invalid_argument for a parameter outside its range.
  Lidar(const LidarParams& params, const Walls& walls);

  // Exact ranges [m] from the laser's pose in the map frame; `out` holds all beams. Beams that hit nothing
  // within range_max are +inf, walls nearer than range_min -inf.
  void scan(const Pose2& laser, std::span<float> out);

  // The same for beams [first, last) only; the others of `out` (all beams) are left alone.
  void scan_sector(const Pose2& laser, int first, int last, std::span<float> out);

  // Range noise and lost beams on a complete scan.
  void add_noise(std::span<float> ranges, Rng& rng) const;

  // The header that belongs to `ranges`.
  LaserScan view(std::span<const float> ranges) const noexcept;

  const LidarParams& params() const noexcept { return params_; }

 private:
  void cast_wedge(const Pose2& laser, int first, int last, std::span<float> out);
  std::size_t gather(const Pose2& laser, int first, int last);
  void index_vertices(std::size_t count);
  void settle_indices(std::size_t count);
  void draw_block(std::size_t first, std::size_t count, int first_beam, int last_beam);
  void write_ranges(int first, int last, std::span<float> out) const;
  void drop_blocks(std::span<float> ranges, Rng& rng) const;

  LidarParams params_;
  const Walls* walls_;
  std::vector<double> cos_, sin_;      // of each beam, in the laser's frame
  std::vector<double> inverse_range_;  // the depth buffer [1/m]
  std::vector<double> x_, y_;          // vertices in the laser's frame [m]
  std::vector<int> beam_;              // first beam at or after each vertex
  std::vector<int> last_doubtful_;     // beams from beam_ to this one need the exact test
  std::vector<std::size_t> counts_;    // vertices of each block gathered for this wedge
};

}  // namespace firstlap::sim
