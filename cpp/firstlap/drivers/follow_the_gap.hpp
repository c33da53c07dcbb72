// Follow the gap (V. Sezer and M. Gokasan, Robotics and Autonomous Systems 60(9), 2012) in its F1TENTH form, with the
// car's width and turning circle. Every return is inflated by half the car's width, the nearest one by a bubble. Among
// the directions that stay free the best run is chosen, and an aim within it. The steering angle is proportional to the
// aim's angle; if the body would touch something along its arc, the nearest angle with a free arc is used.
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/reactive_control.hpp"
#include "firstlap/drivers/sweep.hpp"

namespace firstlap::drivers {

struct GapParams {
  double view_angle = 1.4;
  double body_margin = 0.1;
  double bubble_radius = 0.35;
  double free_distance = 2.5;
  double run_power = 1.0;
  double window_angle = 0.25;
  double center_weight = 0.5;
  double arc_margin = 0.05;
  double arc_distance = 0.6;
  double arc_time = 0.2;

  static constexpr auto fields() {
    using P = GapParams;
    return std::tuple{
        Field{"view_angle", &P::view_angle, "rad", 0.3, 2.3, "directions farther to the side are ignored"},
        Field{"body_margin", &P::body_margin, "m", 0.0, 1.0, "returns are inflated by half the car's width plus this"},
        Field{"bubble_radius", &P::bubble_radius, "m", 0.0, 2.0,
              "radius of the occupied bubble around the nearest return"},
        Field{"free_distance", &P::free_distance, "m", 0.3, 30.0,
              "a direction is free if the car could drive this far (less if there is none)"},
        Field{"run_power", &P::run_power, "", 0.0, 4.0,
              "a run of free directions scores the sum of their distances to this power (0: widest run)"},
        Field{"window_angle", &P::window_angle, "rad", 0.01, 1.5, "size of the window with the largest mean distance"},
        Field{"center_weight", &P::center_weight, "", 0.0, 1.0,
              "aim between the best window (0) and the middle of the run (1)"},
        Field{"arc_margin", &P::arc_margin, "m", 0.0, 0.5, "clearance of the car's body along its arc"},
        Field{"arc_distance", &P::arc_distance, "m", 0.0, 5.0, "minimum free distance along an arc"},
        Field{"arc_time", &P::arc_time, "s", 0.0, 2.0, "minimum free travel time along an arc"},
    };
  }
};

struct FollowTheGapParams {
  CarGeometry car{};
  SweepParams scan{};
  GapParams gap{};
  SteeringParams steering{};
  SpeedParams speed{};
};

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, FollowTheGapParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("car", params.car);
  visit("scan", params.scan);
  visit("gap", params.gap);
  visit("steering", params.steering);
  visit("speed", params.speed);
}

// Throws std::invalid_argument with section, field, value and allowed range.
void validate(const FollowTheGapParams& params);

class FollowTheGap final : public Driver {
 public:
  // The grid of directions: straight ahead, and this many to either side.
  static constexpr int directions_per_side = 180;
  static constexpr std::size_t directions = 2 * directions_per_side + 1;

  // Intermediate results of the last step. Angles in the LiDAR's frame, left positive.
  struct Trace {
    Trace() : free(directions), ranges(max_points) {}
    Buffer<double> free;              // [m] free distance per direction, right to left, 0 in the bubble
    Buffer<double> ranges;            // [m] per beam, right to left, repaired and clipped
    double first_beam = 0.0;          // [rad] direction of the first range
    double beam_step = 0.0;           // [rad] between ranges
    double step = 0.0;                // [rad] between directions
    double threshold = 0.0;           // [m] minimum distance of a free direction
    int run_first = 0, run_last = 0;  // directions of the chosen run, -directions_per_side to directions_per_side
    double window = 0.0;              // [rad] middle of the best window
    double aim = 0.0;                 // [rad]
    Point2 nearest{};                 // [m] base_link, center of the bubble
    double wanted = 0.0;              // [rad] steering angle before arcs are tried
    double arc = 0.0;                 // [rad] steering angle of the chosen arc
    double arc_free = 0.0;            // [m] free distance along the arc
    double aim_free = 0.0;            // [m] free distance in the direction of the aim
    StepResult result{};

    static constexpr auto columns() {
      using C = Trace;
      constexpr auto run = [](const C& t) { return std::pair{t.run_first * t.step, t.run_last * t.step}; };
      return std::tuple{
          Column{"ranges", &C::ranges, "m", "per beam, right to left, repaired and clipped"},
          Column{"first_beam", &C::first_beam, "rad", "direction of the first range, in the LiDAR's frame"},
          Column{"beam_step", &C::beam_step, "rad", "between ranges"},
          Column{"free", &C::free, "m", "free distance per direction, right to left, 0 in the bubble"},
          Column{"step", &C::step, "rad", "between directions; the middle one is straight ahead"},
          Column{"threshold", &C::threshold, "m", "minimum distance of a free direction"},
          Column{"run", run, "rad", "first and last direction of the chosen run"},
          Column{"window", &C::window, "rad", "middle of the best window"},
          Column{"aim", &C::aim, "rad", "direction of the aim"},
          Column{"aim_free", &C::aim_free, "m", "free distance in the direction of the aim"},
          Column{"nearest", &C::nearest, "m", "center of the bubble, base_link"},
          Column{"wanted", &C::wanted, "rad", "steering angle before arcs are tried"},
          Column{"arc", &C::arc, "rad", "steering angle of the chosen arc"},
          Column{"arc_free", &C::arc_free, "m", "free distance along the chosen arc"},
          Column{"result", &C::result, "", "speed, steering angle and status"},
      };
    }
  };

  // Throws std::invalid_argument with section, field, value and allowed range.
  explicit FollowTheGap(const FollowTheGapParams& params);

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override {
    steering_ = 0.0;
    speed_ = no_command;
    period_ = {};
  }

  [[nodiscard]] const FollowTheGapParams& params() const noexcept { return params_; }
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }

 private:
  [[nodiscard]] double& free_at(int k) noexcept {
    const int index = k + directions_per_side;
    return trace_.free[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] double angle_of(int k) const noexcept { return trace_.step * k; }
  void inflate() noexcept;
  [[nodiscard]] std::size_t nearest_of(int first, int last) const noexcept;
  void cast_shadow(std::size_t beam, double radius) noexcept;
  void apply_bubble() noexcept;
  bool choose_run() noexcept;
  bool best_run(double threshold) noexcept;
  void choose_aim() noexcept;
  void choose_arc(const VehicleState& state) noexcept;
  StepResult stop(double dt, Status why) noexcept;

  FollowTheGapParams params_;
  Sweep sweep_;
  Trace trace_;
  double steering_ = 0.0;      // [rad] last command
  double speed_ = no_command;  // [m/s] last command
  ScanPeriod period_{};
};

}  // namespace firstlap::drivers
