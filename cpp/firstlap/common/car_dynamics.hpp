// The car's response to commands, shared by planner and simulator.
#pragma once

#include <tuple>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/field.hpp"

namespace firstlap {

struct CarDynamics {
  double servo_time_constant = 0.06;
  double steering_delay = 0.04;
  double speed_delay = 0.0;
  double speed_gain = 8.0;
  double brake_max = 7.0;

  static constexpr auto fields() {
    using C = CarDynamics;
    return std::tuple{
        Field{"servo_time_constant", &C::servo_time_constant, "s", 0.005, 1.0, "first-order lag of the servo"},
        Field{"steering_delay", &C::steering_delay, "s", 0.0, 0.5, "transport delay of the steering command"},
        Field{"speed_delay", &C::speed_delay, "s", 0.0, 0.5, "transport delay of the speed command"},
        Field{"speed_gain", &C::speed_gain, "1/s", 0.1, 100.0, "gain of the speed loop: acceleration per speed error"},
        Field{"brake_max", &C::brake_max, "m/s^2", 0.1, 50.0, "deceleration limit of the brake, as a positive number"},
    };
  }
};

// [s] Response time of the speed to a changed command: transport delay plus time constant of the speed loop.
inline double speed_response_time(const CarDynamics& car) noexcept { return car.speed_delay + 1.0 / car.speed_gain; }

// The planner's model of the car.
struct CarModel : CarGeometry, CarDynamics {
  static constexpr auto fields() { return std::tuple_cat(CarGeometry::fields(), CarDynamics::fields()); }
};

}  // namespace firstlap
