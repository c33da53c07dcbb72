// All state of the method between scans.
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

// Positions are in the current base_link. Assignment copies everything and does not allocate: resets and replays from
// any step are one assignment.
struct RacerMemory {
  RacerMemory() : path(max_path_points), trail(max_trail_points) {}

  LocalWalls path_walls;             // of the last planned path
  LocalWalls last_walls;             // of the last valid scan, with or without a path
  Buffer<TrajectoryPoint> path;      // the last planned path
  LineEnd line_end = LineEnd::none;  // of the centerline of that path
  double time_without_path = 0.0;    // [s] since it was planned
  Buffer<TrailPoint> trail;          // past poses of the car
  double since_trail_point = 0.0;    // [m] since the last trail point
  std::optional<double> width{};     // [m] track width, once measured
  double moved = 0.0;                // [m] assumed forward motion since `last_walls`
  double moved_measured = 0.0;       // [m] measured forward motion since `last_walls`
  ScanPeriod period{};               // of the scans
  VehicleState measured{};           // state of the previous step
  double speed = 0.0;                // [m/s] corrected speed of the previous step
  SpeedScale speed_scale{};          // estimate of the speed scale error
  DriveCommand command{};            // of the previous step
  bool initialized = false;          // a scan has been processed
  bool braking = false;              // full braking, by decision of the stopping check
};

// [m] The remembered track width, or its initial value.
inline double width_of(const RacerMemory& memory, const TrackWidthParams& params) noexcept {
  return memory.width.value_or(params.width_initial);
}

// Updates the command scale with the response to the last command. Returns true speed per measured speed.
double learn_from_driving(const VehicleState& measured, double dt, const CarDynamics& car,
                          const SpeedScaleParams& params, RacerMemory& memory) noexcept;

// Dead reckoning: transforms everything remembered into base_link `dt` [s] later, when the car has `state`. `scale`:
// true speed per measured speed.
void move_by_odometry(const VehicleState& state, double scale, double dt, const CenterlineParams& params,
                      RacerMemory& memory) noexcept;

// Updates the speed scale by matching the walls of this scan with those of the last valid scan.
void learn_from_scan(const Buffer<SectionSample>& samples, double dt, const SpeedScaleParams& params,
                     RacerMemory& memory) noexcept;

// Updates the track width from a centerline of this scan. Returns true if the remembered width changed. `widths`: a
// buffer.
bool learn_width(const Centerline& line, const TrackWidthParams& params, Buffer<double>& widths,
                 RacerMemory& memory) noexcept;

// Forgets the sides of walls, after the car was turned around.
void forget_direction(RacerMemory& memory) noexcept;

// Remembers the walls of a valid scan, with or without a path: the stopping check uses them.
void remember_walls(const LocalWalls& walls, RacerMemory& memory) noexcept;

// Remembers a planned path with its walls and the end of its centerline.
void remember_path(const Buffer<TrajectoryPoint>& path, const LocalWalls& walls, LineEnd end,
                   RacerMemory& memory) noexcept;

}  // namespace firstlap
