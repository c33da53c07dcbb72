// The whole method: one LiDAR scan in, one command out. The only class with memory.
#pragma once

#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/racer_params.hpp"
#include "firstlap/drivers/trace.hpp"
#include "firstlap/estimation/speed_scale.hpp"
#include "firstlap/perception/scan_period.hpp"
#include "firstlap/planning/minimum_curvature.hpp"

namespace firstlap {

class Racer final : public Driver {
 public:
  // Throws std::invalid_argument: field, value, allowed range.
  explicit Racer(const Params& params);

  StepResult step(const LaserScan& scan, const VehicleState& measured, double dt) noexcept override;
  void reset() noexcept override;

  // Changes the parameters while driving; throws as the constructor and then keeps the old ones.
  void set_params(const Params& params);
  [[nodiscard]] const Params& params() const noexcept { return params_; }
  // What the last step saw and thought; valid until the next one.
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }

 private:
  // All that lasts from one scan to the next.
  struct Memory {
    Memory() : walls(), seen(), path(max_path_points), trail(max_trail_) {}
    LocalWalls walls;                  // by the last planned path
    LocalWalls seen;                   // by the last good scan, path or not
    Buffer<TrajectoryPoint> path;      // the last one planned
    Buffer<TrailPoint> trail;          // where the car has been
    double width = 0.0;                // [m]
    bool width_known = false;          // it was measured, not assumed
    double without_path = 0.0;         // [s] since the last planned path
    double trail_step = 0.0;           // [m] since the last trail point
    LineEnd line_end = LineEnd::none;  // of the line that the path follows
    ScanPeriod period{};               // of the scans
    double moved = 0.0;                // [m] forward since `seen`, as taken
    double measured = 0.0;             // [m] and as measured
    VehicleState measured_state{};     // the last measured
    VehicleState state{};              // and what it was taken for
    SpeedScale speed_scale{};          // how far the car's speeds are wrong
    double speed_command = 0.0;        // [m/s] the last commanded
    double steering_command = 0.0;     // [rad] the last commanded
    bool awake = false;                // a scan has been seen
    bool braking = false;              // fully, since nothing else would have stopped the car
  };

  static constexpr std::size_t max_trail_ = 256;

  // What lies on the path.
  struct StopAhead {
    bool near = false;        // the car has to stop just ahead
    bool full_brake = false;  // planned braking would not stop it before
  };

  VehicleState move_memory(const VehicleState& measured, double dt) noexcept;
  void learn_speed_scale(double dt) noexcept;
  bool perceive(const LaserScan& scan, const VehicleState& state) noexcept;
  void choose_line() noexcept;
  void forget_direction() noexcept;
  void build_line(std::size_t split, LocalWalls& walls, Centerline& line) noexcept;
  bool plan(const VehicleState& state) noexcept;
  bool learn_width() noexcept;
  void remember_seen() noexcept;
  StopAhead brake_for_obstacles(double speed) noexcept;
  StepResult follow(const VehicleState& state, double dt, Status status) noexcept;
  DriveCommand commanded(const VehicleState& state, double speed, double wheels, double dt) noexcept;
  bool can_still_stop(const VehicleState& state, double dt, double& wheels) noexcept;
  StepResult hold_or_stop(const VehicleState& state, double dt, Status why) noexcept;
  StepResult stop_blind(double dt) noexcept;
  StepResult stop(const VehicleState& state, double dt, Status why) noexcept;
  double limited_steering(double wanted, double dt) noexcept;

  Params params_;
  Trace trace_;
  Memory memory_;
  BeamTable table_;
  Buffer<float> ranges_;
  LocalWalls other_walls_;  // of a candidate that is being tried
  Centerline other_line_;
  Spline spline_;
  Buffer<double> widths_;
  Buffer<ControlPoint> control_points_;
};

}  // namespace firstlap
