// The stages of one step of the map-less method. Each writes its results to `work.step`.
#pragma once

#include "firstlap/drivers/racer_memory.hpp"
#include "firstlap/drivers/racer_workspace.hpp"

namespace firstlap {

// Perception: scan to points, sections and labeled samples. Returns false if the scan is unusable.
bool perceive(const LaserScan& scan, const VehicleState& state, const RacerMemory& memory, const Params& params,
              RacerWorkspace& work) noexcept;

// Perception and planning: chooses the split into left and right sections, then the walls and the centerline between
// them. If the centerline passes the car against its heading, the car was turned around: the remembered sides are
// cleared, and the split is chosen again.
void find_line(const Params& params, RacerMemory& memory, RacerWorkspace& work) noexcept;

// Planning: path and velocity profile along the centerline, for a car in `state`. Returns false if there is no path.
bool plan_path(const VehicleState& state, const RacerMemory& memory, const Params& params,
               RacerWorkspace& work) noexcept;

// Holds the last planned path for a short time. Returns false if it is too old or too short.
bool recall_path(const RacerMemory& memory, const Params& params, RacerWorkspace& work) noexcept;

// The intended motion along the path.
struct Maneuver {
  double speed = 0.0;           // [m/s]
  double steering_angle = 0.0;  // [rad]
  bool braking = false;         // full braking, by decision of the stopping check
  bool blocked = false;         // an obstacle is on the path just ahead, or the car brakes fully
};

// Control: the maneuver along the path. Lowers the velocity profile in front of obstacles.
Maneuver follow_path(const VehicleState& state, double dt, const RacerMemory& memory, const Params& params,
                     RacerWorkspace& work) noexcept;

}  // namespace firstlap
