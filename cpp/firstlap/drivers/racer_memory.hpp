// What the method keeps from one scan to the next: all of it, and nowhere else.
#pragma once

#include <cstddef>
#include <optional>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/drivers/racer_params.hpp"
#include "firstlap/estimation/speed_scale.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/scan_period.hpp"
#include "firstlap/planning/centerline.hpp"
#include "firstlap/planning/trajectory.hpp"

namespace firstlap {

inline constexpr std::size_t max_trail_points = 256;

// Positions are in today's base_link. Assigning one to another copies all of it and allocates nothing: that is a reset
// and a replay from any step.
struct RacerMemory {
  RacerMemory() : path(max_path_points), trail(max_trail_points) {}

  LocalWalls walls;                  // by the last planned path
  LocalWalls seen;                   // by the last good scan, path or not
  Buffer<TrajectoryPoint> path;      // the last one planned
  LineEnd line_end = LineEnd::none;  // of the centerline that it follows
  double without_path = 0.0;         // [s] since it was planned
  Buffer<TrailPoint> trail;          // where the car has been
  double trail_step = 0.0;           // [m] since the last trail point
  std::optional<double> width{};     // [m] of the track, once it was measured
  double moved = 0.0;                // [m] forward since `seen`, as taken
  double moved_measured = 0.0;       // [m] and as measured
  ScanPeriod period{};               // of the scans
  VehicleState measured{};           // the last one
  double speed = 0.0;                // [m/s] what its speed was taken for
  SpeedScale speed_scale{};          // how far the car's speeds are wrong
  DriveCommand command{};            // the last one
  bool awake = false;                // a scan has been seen
  bool braking = false;              // fully, since nothing else would have stopped the car
};

// [m] of the track: as measured, or else as assumed.
inline double width_of(const RacerMemory& memory, const TrackWidthParams& params) noexcept {
  return memory.width.value_or(params.width_initial);
}

// Learns from what the car made of its last command, and gives true speed per measured speed.
double learn_from_driving(const VehicleState& measured, double dt, const SpeedScaleParams& params,
                          RacerMemory& memory) noexcept;

// Dead reckoning: all that is remembered, expressed in the base_link of `dt` [s] later, where the car has `state`.
// `scale`: its true speed per measured speed.
void move_by_odometry(const VehicleState& state, double scale, double dt, const CenterlineParams& params,
                      RacerMemory& memory) noexcept;

// Learns the speed scale from how the walls of this scan lie to those of the last good one.
void learn_from_scan(const Buffer<SectionSample>& samples, double dt, const SpeedScaleParams& params,
                     RacerMemory& memory) noexcept;

// The track width along a centerline of this scan. True where it changed what is remembered. `widths`: a buffer.
bool learn_width(const Centerline& line, const TrackWidthParams& params, Buffer<double>& widths,
                 RacerMemory& memory) noexcept;

// The car was turned round: what is known of the walls' sides is of the other direction.
void forget_direction(RacerMemory& memory) noexcept;

// The walls of a good scan: what the brakes work on, whether a path is found or not.
void remember_seen(const LocalWalls& walls, RacerMemory& memory) noexcept;

// A planned path with the walls and the end of the line that it follows.
void remember_path(const Buffer<TrajectoryPoint>& path, const LocalWalls& walls, LineEnd end,
                   RacerMemory& memory) noexcept;

}  // namespace firstlap
