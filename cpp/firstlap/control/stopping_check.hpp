// Before a command goes out: could the car still stop without touching anything if it did what the command says
// until the next scan, and braked fully from then on? What was seen decides, wall or not, and so does how the car
// really moves: its body, the servo's lag, the lock and the grip, not the path alone.
#pragma once

#include <cstddef>
#include <limits>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/control/params.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

struct StoppingCheck {
  static constexpr double never = std::numeric_limits<double>::infinity();

  bool clear = true;            // nothing is touched on the way to the stop
  double distance = never;      // [m] driven until something would be touched
  double clearance = never;     // [m] smallest, body to what was seen, until then
  double steering_angle = 0.0;  // [rad] to command when the braking begins
};

// Where a stop begins.
struct StopScene {
  const Buffer<TrajectoryPoint>& path;  // in base_link
  std::size_t nearest;                  // its point next to the front axle
  const LocalWalls& walls;              // what was seen
  const VehicleState& state;            // measured
};

// What the stopping check needs to know of the car and its limits.
struct StopLimits {
  const CarModel& car;
  const VelocityProfileParams& profile;
  const StoppingCheckParams& check;
  double a_brake = profile.a_brake;  // [m/s^2] full braking
};

// How the wheels are held on the way to the stop.
enum class StopSteering { to_path, kept, straight };

// Until `delay` [s] the wheels go where `command` [rad] tells them, then the brakes bite.
struct Stop {
  double command = 0.0;
  double delay = 0.0;
  StopSteering how = StopSteering::to_path;
};

StoppingCheck check_stopping(const StopScene& scene, const Stop& stop, const StopLimits& limits) noexcept;

struct StopDecision {
  bool brake = false;           // fully, now
  double steering_angle = 0.0;  // [rad] with it, or as wanted
};

// Brakes where a car that did as it is told (`wanted` [rad]) for another `dt` [s], until the next scan, could no longer
// stop without touching anything; then with the wheels such that it gets furthest. A car that is `braking` goes on
// until there is some room again.
StopDecision decide_stop(const StopScene& scene, double wanted, double dt, bool braking,
                         const StopLimits& limits) noexcept;

// The steering angle nearest to `angle` [rad] that asks a braking car at `speed` [m/s] for no more grip than there is.
double within_grip(double angle, double speed, const StopLimits& limits) noexcept;

}  // namespace firstlap
