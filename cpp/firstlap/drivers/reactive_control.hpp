// Shared by the reactive drivers: speed from free distance and curvature, steering within grip and servo limits, and
// the area swept by the car's body.
#pragma once

#include <limits>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap::drivers {

inline constexpr double no_command = std::numeric_limits<double>::infinity();  // [m/s] no command has been given yet

struct SpeedParams {
  double v_min = 1.0;
  double v_max = 5.0;
  double a_y_max = 3.5;
  double a_x_min = -4.0;
  double stop_distance = 0.25;
  double delta_v_max = 0.6;
  double delta_v_min = -0.6;

  static constexpr auto fields() {
    using P = SpeedParams;
    return std::tuple{
        Field{"v_min", &P::v_min, "m/s", 0.1, 10.0, "minimum speed, except for a stop"},
        Field{"v_max", &P::v_max, "m/s", 0.1, 20.0, "maximum speed"},
        Field{"a_y_max", &P::a_y_max, "m/s^2", 0.1, 20.0, "maximum lateral acceleration"},
        Field{"a_x_min", &P::a_x_min, "m/s^2", -20.0, -0.1,
              "deceleration with which the car must be able to stop within the free distance, as a negative number"},
        Field{"stop_distance", &P::stop_distance, "m", 0.0, 2.0,
              "the car stops if the free distance is less than this"},
        Field{"delta_v_max", &P::delta_v_max, "m/s", 0.0, 10.0, "maximum of commanded minus measured speed"},
        Field{"delta_v_min", &P::delta_v_min, "m/s", -10.0, 0.0, "minimum of commanded minus measured speed"},
    };
  }
};

struct SteeringParams {
  double steering_gain = 0.7;
  double steering_time = 0.025;
  double a_y_steer = 8.0;

  static constexpr auto fields() {
    using P = SteeringParams;
    return std::tuple{
        Field{"steering_gain", &P::steering_gain, "", 0.05, 3.0, "steering angle per aim angle"},
        Field{"steering_time", &P::steering_time, "s", 0.0, 0.5,
              "time constant of the low-pass filter of the steering angle"},
        Field{"a_y_steer", &P::a_y_steer, "m/s^2", 0.5, 30.0,
              "the steering angle is limited to this lateral acceleration at the measured speed"},
    };
  }
};

// Start of the next speed command.
struct SpeedNow {
  double measured = 0.0;   // [m/s]
  double commanded = 0.0;  // [m/s] last command; infinite before the first
  double dt = 0.0;         // [s] since then
};

// Speed [m/s] for a free distance `free` [m] and a curvature [1/m]: sqrt(2 a free) and sqrt(a_y / |curvature|), limited
// relative to the measured speed. An overestimated measured speed does not prevent braking: the command may always fall
// with a_x_min.
double plan_speed(double free, double curvature, const SpeedNow& now, const SpeedParams& params) noexcept;

// The steering angle `wanted` [rad], limited by the servo and by `a_y_steer` at `speed` [m/s]: atan(l a_y / v^2).
double within_grip(double wanted, double speed, const SteeringParams& params, const CarGeometry& car) noexcept;

// One step from the commanded steering angle `before` [rad] toward `wanted` [rad]: low-pass filter with time constant
// `time` [s], and steering rate limit.
double smooth_steering(double wanted, double before, double dt, double time, const CarGeometry& car) noexcept;

// [1/m] Curvature of the rear axle's path at a steering angle [rad].
double curvature_of(double steering_angle, const CarGeometry& car) noexcept;

// Lateral clearance [m] between the car's sides and the nearest returns beside it.
struct LateralClearance {
  double left = 1e3;
  double right = 1e3;
};
LateralClearance lateral_clearance(const Buffer<Point2>& points, const CarGeometry& car) noexcept;

// The margin [m] `wanted` on either side of the body, reduced if returns are closer: else no arc would be free.
double margin_beside(const Buffer<Point2>& points, double wanted, const CarGeometry& car) noexcept;

// Distance [m] that the car can drive along the circle of `curvature` [1/m] until its body, `margin` [m] wider on
// either side, touches one of `points` (base_link); at most `farthest` [m]. The swept area is exact: a ring from the
// inner side at the rear axle to the outer front corner.
double free_along_arc(const Buffer<Point2>& points, double curvature, double margin, double farthest,
                      const CarGeometry& car) noexcept;

}  // namespace firstlap::drivers
