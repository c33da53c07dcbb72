// The stages of a step of the method: inputs, parameters, output. Each writes its results to `work.step`.
#pragma once

#include "firstlap/drivers/racer_memory.hpp"
#include "firstlap/drivers/racer_workspace.hpp"

namespace firstlap {

// Perception: the scan as points, sections and samples, these with the side that they had before. False where the scan
// is of no use.
bool perceive(const LaserScan& scan, const VehicleState& state, const RacerMemory& memory, const Params& params,
              RacerWorkspace& work) noexcept;

// Perception and planning: which sections are left and which right, the walls, and the centerline between them. A line
// that leads back is of a car that was turned round: what is remembered of the walls' sides is forgotten then.
void find_line(const Params& params, RacerMemory& memory, RacerWorkspace& work) noexcept;

// Planning: path and speeds along the centerline, for a car in `state`. False where there is none to follow.
bool plan_path(const VehicleState& state, const Params& params, RacerWorkspace& work) noexcept;

// The last planned path instead, for a short while. False where it is too old or too short.
bool recall_path(const RacerMemory& memory, const Params& params, RacerWorkspace& work) noexcept;

// What the car is to do on its path.
struct Maneuver {
  double speed = 0.0;           // [m/s]
  double steering_angle = 0.0;  // [rad]
  bool braking = false;         // fully, since nothing else would stop the car
  bool blocked = false;         // something stands on the path, just ahead, or the car brakes fully
};

// Control: the maneuver, and the speeds of the path lowered before what stands on it.
Maneuver follow_path(const VehicleState& state, double dt, const RacerMemory& memory, const Params& params,
                     RacerWorkspace& work) noexcept;

}  // namespace firstlap
