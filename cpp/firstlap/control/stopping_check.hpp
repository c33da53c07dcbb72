// Before a command goes out: could the car still stop without touching anything if it did what the command says
// until the next scan, and braked fully from then on? What was seen decides, wall or not, and so does how the car
// really moves: its body, the servo's lag, the lock and the grip, not the path alone.
#pragma once

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/planning/params.hpp"

namespace firstlap {

struct StoppingCheck {
  bool clear = true;       // nothing is touched on the way to the stop
  double distance = 1e9;   // [m] driven until something would be touched
  double clearance = 1e9;  // [m] smallest, body to what was seen, until then
  double wheels = 0.0;     // [rad] the angle to command when the braking begins
};

// How the wheels are held on the way to the stop.
enum class StopSteering { to_path, kept, straight };

// The stop from the measured `state`: until `delay` [s] the wheels go where `command` [rad] tells them, then the brakes
// bite; along `path` (in base_link, its point `nearest` next to the front axle) or with the wheels held.
StoppingCheck check_stopping(const Buffer<TrajectoryPoint>& path, std::size_t nearest, const LocalWalls& walls,
                             const VehicleState& state, double command, double delay, StopSteering how,
                             const CarGeometry& car, const VelocityProfileParams& params) noexcept;

// The wheel angle nearest to `angle` [rad] that asks a braking car at `speed` [m/s] for no more grip than there is.
double within_grip(double angle, double speed, const CarGeometry& car, const VelocityProfileParams& params) noexcept;

}  // namespace firstlap
