// Step 7: the four-term Stanley law with an adaptive lookahead.
#pragma once

#include <cstddef>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/control/params.hpp"

namespace firstlap {

// Every part of one steering command, for the picture and the log.
struct SteeringTerms {
  double heading_error = 0.0;      // [rad] path minus car, with the steady-state yaw
  double cross_track_error = 0.0;  // [m] of the path, left of the front axle positive
  double yaw_rate_error = 0.0;     // [rad/s] car minus path
  double steering_change = 0.0;    // [rad] of the measured wheel angle since the last scan
  double heading = 0.0;            // [rad] the four terms of the command
  double cross_track = 0.0;
  double yaw_rate = 0.0;
  double steering = 0.0;
  double lookahead = 0.0;       // [m]
  double k_ang = 0.0;           // in force, after the schedule
  double steering_angle = 0.0;  // [rad] their sum, not yet limited
};

// Steering for the path, whose point `from` is nearest to the front axle. `point` receives the
// lookahead point.
SteeringTerms track_path(const Buffer<TrajectoryPoint>& path, std::size_t from, const VehicleState& state,
                         double previous_steering, const StanleyParams& params, const CarGeometry& car,
                         TrajectoryPoint& point) noexcept;

}  // namespace firstlap
