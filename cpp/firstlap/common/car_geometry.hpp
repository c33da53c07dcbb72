// The car's body, shared by planner and simulator. base_link is the center of the rear axle.
#pragma once

#include <cmath>
#include <tuple>

#include "firstlap/common/field.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap {

struct CarGeometry {
  double wheelbase = 0.33;
  double width = 0.31;
  double length = 0.58;
  double rear_overhang = 0.125;
  double laser_x = 0.27;
  double laser_y = 0.0;
  double steering_limit = 0.4189;
  double steering_rate = 3.2;

  static constexpr auto fields() {
    using C = CarGeometry;
    return std::tuple{
        Field{"wheelbase", &C::wheelbase, "m", 0.1, 1.0, "rear axle to front axle"},
        Field{"width", &C::width, "m", 0.1, 1.0, "across the tires"},
        Field{"length", &C::length, "m", 0.2, 2.0, "bumper to bumper"},
        Field{"rear_overhang", &C::rear_overhang, "m", 0.0, 0.5, "rear axle to rear bumper"},
        Field{"laser_x", &C::laser_x, "m", -0.5, 1.0, "LiDAR position ahead of the rear axle"},
        Field{"laser_y", &C::laser_y, "m", -0.5, 0.5, "LiDAR position left of the car's center line"},
        Field{"steering_limit", &C::steering_limit, "rad", 0.1, 1.0, "maximum steering angle to either side"},
        Field{"steering_rate", &C::steering_rate, "rad/s", 0.5, 20.0, "maximum rate of the steering angle"},
    };
  }
};

// [1/m] Curvature of the smallest circle that base_link can drive.
inline double tightest_curvature(const CarGeometry& car) noexcept {
  return std::tan(car.steering_limit) / car.wheelbase;
}

// [m] Distance from the front axle to the front bumper.
inline double nose(const CarGeometry& car) noexcept { return car.length - car.rear_overhang - car.wheelbase; }

// The car's rectangle in base_link, enlarged by `margin` [m] on every side.
struct Footprint {
  explicit Footprint(const CarGeometry& car, double margin = 0.0) noexcept
      : front(car.length - car.rear_overhang + margin),
        rear(-car.rear_overhang - margin),
        side(0.5 * car.width + margin) {}

  [[nodiscard]] bool covers(Point2 p) const noexcept { return p.x > rear && p.x < front && std::abs(p.y) < side; }

  double front;  // [m] x of the front edge
  double rear;   // [m] x of the rear edge
  double side;   // [m] y of the left edge; the right edge is at -side
};

}  // namespace firstlap
