// The whole method: one LiDAR scan in, one command out. The only class with memory.
#pragma once

#include "firstlap/driver.hpp"
#include "firstlap/least_curvature.hpp"
#include "firstlap/params.hpp"
#include "firstlap/trace.hpp"

namespace firstlap {

class Racer final : public Driver {
 public:
  // Throws std::invalid_argument: field, value, allowed range.
  explicit Racer(const Params& params);

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override;

  // Changes the parameters while driving; throws as the constructor and then keeps the old ones.
  void set_params(const Params& params);
  [[nodiscard]] const Params& params() const noexcept { return params_; }
  // What the last step saw and thought; valid until the next one.
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }

 private:
  // All that lasts from one scan to the next.
  struct Memory {
    Memory() : walls(), path(max_path_points), trail(max_trail_) {}
    WallsSeen walls;                // as the last scan left them
    Buffer<TrajectoryPoint> path;   // the last one planned
    Buffer<TrailPoint> trail;       // where the car has been
    double width = 0.0;             // [m]
    bool width_known = false;       // it was measured, not assumed
    double without_path = 0.0;      // [s] since the last planned path
    double trail_step = 0.0;        // [m] since the last trail point
    VehicleState state{};           // the last measured
    double steering_command = 0.0;  // [rad] the last commanded
    bool awake = false;             // a scan has been seen
    bool braking = false;           // fully, since nothing else would have stopped the car
  };

  static constexpr std::size_t max_trail_ = 256;

  void move_memory(const VehicleState& state, double dt) noexcept;
  bool perceive(const LaserScan& scan, const VehicleState& state) noexcept;
  void choose_line() noexcept;
  void forget_the_way() noexcept;
  void build_line(std::size_t split, WallsSeen& walls, Centerline& line) noexcept;
  bool plan(const VehicleState& state) noexcept;
  bool learn_width() noexcept;
  bool keep_clear(double speed) noexcept;
  StepResult follow(const VehicleState& state, double dt, Status status) noexcept;
  bool can_still_stop(const VehicleState& state, double dt, double& wheels) noexcept;
  StepResult hold_or_stop(const VehicleState& state, double dt, Status why) noexcept;
  StepResult stop(const VehicleState& state, double dt, Status why) noexcept;
  double limited_steering(double wanted, double dt) noexcept;

  Params params_;
  Trace trace_;
  Memory memory_;
  BeamTable table_;
  Buffer<float> ranges_;
  WallsSeen other_walls_;  // of a candidate that is being tried
  Centerline other_line_;
  Spline spline_;
  Buffer<double> widths_;
  Buffer<PathKey> keys_;
  bool full_brake_ = false;  // planned braking would not stop the car before it
  bool blocked_ = false;     // something stands on the path just ahead
};

}  // namespace firstlap
