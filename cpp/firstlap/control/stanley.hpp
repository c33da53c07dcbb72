// Step 7: the four-term Stanley law with an adaptive lookahead.
#pragma once

#include <cstddef>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/control/params.hpp"

namespace firstlap {

// Every part of one steering command, for the picture and the log.
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
        Column{"heading_error", &C::heading_error, "rad", "path minus car, with the steady-state yaw"},
        Column{"cross_track_error", &C::cross_track_error, "m", "of the path, left of the front axle positive"},
        Column{"yaw_rate_error", &C::yaw_rate_error, "rad/s", "car minus path"},
        Column{"steering_change", &C::steering_change, "rad", "of the measured steering angle since the last scan"},
        Column{"heading", &C::heading, "rad", "term of the heading error"},
        Column{"cross_track", &C::cross_track, "rad", "term of the cross-track error"},
        Column{"yaw_rate", &C::yaw_rate, "rad", "term of the yaw rate error"},
        Column{"steering", &C::steering, "rad", "term of the steering change"},
        Column{"lookahead", &C::lookahead, "m", "distance"},
        Column{"k_ang", &C::k_ang, "", "in force, after the schedule"},
        Column{"steering_angle", &C::steering_angle, "rad", "sum of the four terms, not yet limited"},
    };
  }
};

// Steering for the path, whose point `from` is nearest to the front axle. `point` receives the
// lookahead point.
SteeringTerms track_path(const Buffer<TrajectoryPoint>& path, std::size_t from, const VehicleState& state,
                         double previous_steering, const StanleyParams& params, const CarGeometry& car,
                         TrajectoryPoint& point) noexcept;

}  // namespace firstlap
