// An exact planar LiDAR without ray marching: a depth buffer over the beam index. Along a wall, 1/r is linear in (cos,
// sin) of the beam angle: 1/r = (n . u) / (n . a) with the wall's normal n, a point a on it and the beam's direction u.
// The nearest wall of each beam has the largest 1/r.
#pragma once

#include <cstddef>
#include <span>
#include <tuple>
#include <vector>

#include "firstlap/common/field.hpp"
#include "firstlap/common/rng.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

// How the LiDAR's ROS driver reports a beam without a return within range_max.
enum class NoReturn : int {
  infinite = 0,   // +inf, as in REP 117
  nan = 1,        // NaN
  zero = 2,       // 0
  range_max = 3,  // clipped at range_max before the noise is added
};

// Defaults: Hokuyo UTM-30LX, facing forward.
struct LidarParams {
  int beams = 1081;
  int beams_vary = 0;
  double fov = 4.7123889804;
  double center_angle = 0.0;
  bool clockwise = false;
  double yaw = 0.0;
  bool upside_down = false;
  double rate = 40.0;
  double range_min = 0.06;
  double range_max = 30.0;
  double range_scale = 1.0;
  int no_return = 0;
  double sweep_time = 0.01875;
  double noise_sigma = 0.01;
  double dropout_rate = 0.002;
  double dropout_block_rate = 0.0;
  int dropout_block_beams = 20;
  double dropout_block_share = 0.0;

  static constexpr auto fields() {
    using P = LidarParams;
    return std::tuple{
        Field{"beams", &P::beams, "", 2.0, 10000.0, "beams per scan"},
        Field{"beams_vary", &P::beams_vary, "", 0.0, 1000.0,
              "a scan may have up to this many beams fewer, over the same angle"},
        Field{"fov", &P::fov, "rad", 0.1, 6.2831853072, "angle from the first beam to the last"},
        Field{"center_angle", &P::center_angle, "rad", -6.2831853072, 6.2831853072,
              "direction of the middle of the scan in the LiDAR's frame (pi: a full turn that starts ahead)"},
        Field{"clockwise", &P::clockwise, "", 0.0, 1.0, "the LiDAR rotates clockwise: angle_increment is negative"},
        Field{"yaw", &P::yaw, "rad", -3.1415926536, 3.1415926536, "mounting yaw of the LiDAR, left"},
        Field{"upside_down", &P::upside_down, "", 0.0, 1.0, "the LiDAR is mounted with a roll of 180 degrees"},
        Field{"rate", &P::rate, "Hz", 5.0, 200.0, "scans per second"},
        Field{"range_min", &P::range_min, "m", 0.0, 1.0, "closer walls give -inf (REP 117)"},
        Field{"range_max", &P::range_max, "m", 1.0, 200.0, "farther walls give no return"},
        Field{"range_scale", &P::range_scale, "", 0.5, 2.0, "measured range over true range"},
        Field{"no_return", &P::no_return, "", 0.0, 3.0,
              "value reported for no return: 0 +inf (REP 117), 1 NaN, 2 zero, 3 range_max with noise"},
        Field{"sweep_time", &P::sweep_time, "s", 0.0, 0.2, "first beam to last; at most one scan period"},
        Field{"noise_sigma", &P::noise_sigma, "m", 0.0, 0.5, "standard deviation of a range"},
        Field{"dropout_rate", &P::dropout_rate, "", 0.0, 1.0, "share of beams lost individually (+inf)"},
        Field{"dropout_block_rate", &P::dropout_block_rate, "", 0.0, 1.0, "share of scans that lose a block of beams"},
        Field{"dropout_block_beams", &P::dropout_block_beams, "", 0.0, 10000.0, "beams per lost block"},
        Field{"dropout_block_share", &P::dropout_block_share, "", 0.0, 0.95, "share of beams lost in blocks"},
    };
  }

  double beam_step() const noexcept { return fov / (beams - 1); }  // [rad] between beams, > 0

  // As reported by the LiDAR's ROS driver, in the LiDAR's own frame [rad].
  double own_angle_increment() const noexcept { return clockwise ? -beam_step() : beam_step(); }
  double own_angle_min() const noexcept { return center_angle - (clockwise ? -0.5 : 0.5) * fov; }

  // The same including the mounting, relative to base_link's heading [rad].
  bool turns_right() const noexcept { return clockwise != upside_down; }
  double middle() const noexcept { return yaw + (upside_down ? -center_angle : center_angle); }
  double angle_increment() const noexcept { return turns_right() ? -beam_step() : beam_step(); }
  double angle_min() const noexcept { return middle() - (turns_right() ? -0.5 : 0.5) * fov; }
};

class Lidar {
 public:
  // Keeps a reference to `walls`. Throws std::invalid_argument for a parameter outside its range.
  Lidar(const LidarParams& params, const Walls& walls);

  // Starts a scan: resizes `ranges` to its number of beams, which varies by `beams_vary`.
  void begin_scan(Rng& rng, std::vector<float>& ranges);

  // Sets the number of beams of all later scans, over the same angle.
  void set_beams(int beams);

  // Exact ranges [m]. `laser`: the LiDAR's position in the map frame with base_link's heading; the mounting angle is in
  // the parameters. `out` holds all beams in scan order. Beams without a wall within range_max are +inf, walls closer
  // than range_min -inf.
  void scan(const Pose2& laser, std::span<float> out);

  // The same for beams [first, last) only; the others of `out` (all beams) are unchanged.
  void scan_sector(const Pose2& laser, int first, int last, std::span<float> out);

  // Adds range noise and lost beams to a complete scan, and replaces missing returns by the value for no return.
  void add_noise(std::span<float> ranges, Rng& rng) const;

  // The scan message of `ranges`, for any number of beams. Its angles include the mounting.
  LaserScan view(std::span<const float> ranges) const noexcept;

  // Of the current scan, with its number of beams.
  const LidarParams& params() const noexcept { return params_; }

 private:
  void cast_sector(const Pose2& laser, int first, int last, std::span<float> out);
  std::size_t gather(const Pose2& laser, int first, int last);
  void index_vertices(std::size_t count);
  void settle_indices(std::size_t count);
  void draw_block(std::size_t first, std::size_t count, int first_beam, int last_beam);
  void write_ranges(int first, int last, std::span<float> out) const;
  void drop_blocks(std::span<float> ranges, Rng& rng) const;

  LidarParams params_;
  int max_beams_ = 0;
  const Walls* walls_;
  // Beams are cast right to left, relative to the middle of the scan; only write_ranges converts to scan order.
  std::vector<double> cos_, sin_;      // of each beam, relative to the middle of the scan
  std::vector<double> inverse_range_;  // [1/m] depth buffer
  std::vector<double> x_, y_;          // [m] vertices, relative to the middle of the scan
  std::vector<int> beam_;              // first beam at or after each vertex
  std::vector<int> last_doubtful_;     // beams from beam_ to this one need the exact test
  std::vector<std::size_t> counts_;    // vertices of each block in the current sector
};

}  // namespace firstlap::sim
