// What the map-less opponents share once they know where to go: speed from free distance and curvature,
// steering within grip and servo, and the way that the car's body sweeps.
#pragma once

#include <limits>
#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap::drivers {

inline constexpr double no_command = std::numeric_limits<double>::infinity();  // [m/s] none has been given yet

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
        Field{"v_min", &P::v_min, "m/s", 0.1, 10.0, "speed never falls below this, but for a stop"},
        Field{"v_max", &P::v_max, "m/s", 0.1, 20.0, "speed never rises above this"},
        Field{"a_y_max", &P::a_y_max, "m/s^2", 0.1, 20.0, "lateral acceleration that the steering may ask for"},
        Field{"a_x_min", &P::a_x_min, "m/s^2", -20.0, -0.1, "braking that the free distance must suffice for"},
        Field{"stop_distance", &P::stop_distance, "m", 0.0, 2.0, "with less free distance the car stops"},
        Field{"delta_v_max", &P::delta_v_max, "m/s", 0.0, 10.0, "commanded speed above the measured one at most"},
        Field{"delta_v_min", &P::delta_v_min, "m/s", -10.0, 0.0, "commanded speed below the measured one at most"},
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
        Field{"steering_gain", &P::steering_gain, "", 0.05, 3.0, "wheel angle per angle of the aim"},
        Field{"steering_time", &P::steering_time, "s", 0.0, 0.5, "time constant of the low pass on the wheel angle"},
        Field{"a_y_steer", &P::a_y_steer, "m/s^2", 0.5, 30.0,
              "no wheel angle that would ask for more lateral acceleration at the measured speed"},
    };
  }
};

// What the next speed command starts from.
struct SpeedNow {
  double measured = 0.0;   // [m/s]
  double commanded = 0.0;  // [m/s] by the last step; infinite before the first
  double dt = 0.0;         // [s] since then
};

// Speed [m/s] for this much free distance [m] and curvature [1/m]: sqrt(2 a free) and sqrt(a_y / |curvature|), near the
// measured speed. A speed that reads high takes no brake away: the command may always fall by a_x_min.
double plan_speed(double free, double curvature, const SpeedNow& now, const SpeedParams& params) noexcept;

// `wanted` [rad] within the wheel's limit and what `a_y_steer` allows at this speed: atan(l a_y / v^2).
double within_grip(double wanted, double speed, const SteeringParams& params, const CarGeometry& car) noexcept;

// One step from the wheel angle commanded `before` toward `wanted` [rad]: low pass and servo's rate.
double smooth_steering(double wanted, double before, double dt, double time, const CarGeometry& car) noexcept;

// [1/m] of the rear axle's way at this wheel angle [rad].
double curvature_of(double steering_angle, const CarGeometry& car) noexcept;

// Room [m] between the car's flanks and the nearest returns beside them.
struct Beside {
  double left = 1e3;
  double right = 1e3;
};
Beside room_beside(const Buffer<Point2>& points, const CarGeometry& car) noexcept;

// How far [m] the car can roll along the circle of `curvature` until its body, `margin` wider on either side,
// meets one of `points` (base_link); at most `farthest`. The body's sweep is exact: a ring from the inner flank
// at the rear axle to the outer front corner.
double free_along_arc(const Buffer<Point2>& points, double curvature, double margin, double farthest,
                      const CarGeometry& car) noexcept;

}  // namespace firstlap::drivers
