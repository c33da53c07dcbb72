// The stopping check, made before each command: could the car still stop without contact if it executed the command
// until the next scan and then braked fully? The check considers all visible and remembered wall samples and the car's
// real motion: body, servo lag, steering limit and grip.
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

  bool clear = true;            // no contact during the stop
  double distance = never;      // [m] driven until contact
  double clearance = never;     // [m] smallest distance of the body to a wall sample until then
  double steering_angle = 0.0;  // [rad] steering angle to command when braking starts
};

// Situation in which a stop starts.
struct StopScene {
  const Buffer<TrajectoryPoint>& path;  // in base_link
  std::size_t nearest;                  // index of the path point nearest to the front axle
  const LocalWalls& walls;              // wall samples in base_link
  const VehicleState& state;            // measured
};

// Parameters of the stopping check.
struct StopLimits {
  const CarModel& car;
  const VelocityProfileParams& profile;
  const StoppingCheckParams& check;
  double a_brake = profile.a_brake;  // [m/s^2] deceleration of full braking
};

// Steering during a stop.
enum class StopSteering { track_path, hold, straight };

// A stop: the steering angle follows `command` [rad] until braking starts after `delay` [s].
struct Stop {
  double command = 0.0;
  double delay = 0.0;
  StopSteering how = StopSteering::track_path;
};

StoppingCheck check_stopping(const StopScene& scene, const Stop& stop, const StopLimits& limits) noexcept;

struct StopDecision {
  bool brake = false;           // brake fully now
  double steering_angle = 0.0;  // [rad] steering angle for it, else the wanted one
};

// Decides to brake if, after driving for `dt` [s] with the steering angle `wanted` [rad] until the next scan, the car
// could no longer stop without contact. It then steers so that it gets farthest. A car that is already `braking`
// continues until it has some reserve (release_share).
StopDecision decide_stop(const StopScene& scene, double wanted, double dt, bool braking,
                         const StopLimits& limits) noexcept;

// The steering angle [rad] nearest to `angle` [rad] for which a braking car at `speed` [m/s] has enough grip.
double within_grip(double angle, double speed, const StopLimits& limits) noexcept;

}  // namespace firstlap
