// Step 7: the four-term Stanley law with an adaptive lookahead.
#pragma once

#include <cstddef>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/control/params.hpp"

namespace firstlap {

// Errors and terms of one steering command, for plots and logs.
struct SteeringTerms {
  double heading_error = 0.0;
  double cross_track_error = 0.0;
  double yaw_rate_error = 0.0;
  double steering_change = 0.0;
  double heading = 0.0;
  double cross_track = 0.0;
  double yaw_rate = 0.0;
  double steering = 0.0;
  double lookahead = 0.0;
  double k_ang = 0.0;
  double steering_angle = 0.0;

  static constexpr auto columns() {
    using C = SteeringTerms;
    return std::tuple{
        Column{"heading_error", &C::heading_error, "rad", "path minus car, including the steady-state yaw"},
        Column{"cross_track_error", &C::cross_track_error, "m",
               "of the path, positive if it lies left of the front axle"},
        Column{"yaw_rate_error", &C::yaw_rate_error, "rad/s", "car minus path"},
        Column{"steering_change", &C::steering_change, "rad", "of the measured steering angle since the previous scan"},
        Column{"heading", &C::heading, "rad", "heading term"},
        Column{"cross_track", &C::cross_track, "rad", "cross-track term"},
        Column{"yaw_rate", &C::yaw_rate, "rad", "yaw-rate term"},
        Column{"steering", &C::steering, "rad", "steering-change term"},
        Column{"lookahead", &C::lookahead, "m", "distance"},
        Column{"k_ang", &C::k_ang, "", "in effect, after scheduling with speed"},
        Column{"steering_angle", &C::steering_angle, "rad", "sum of the four terms, before limits"},
    };
  }
};

// A path and the car on it.
struct TrackedPath {
  const Buffer<TrajectoryPoint>& path;  // in base_link
  std::size_t from;                     // index of the path point nearest to the front axle
  const VehicleState& state;            // measured
  double previous_steering;             // [rad] steering angle measured at the previous scan
};

// Steering terms for a path. Writes the lookahead point to `point`.
SteeringTerms track_path(const TrackedPath& tracked, const StanleyParams& params, const CarGeometry& car,
                         TrajectoryPoint& point) noexcept;

}  // namespace firstlap
