// Parameters of the simulated car besides its geometry and the dynamics known to the planner.
#pragma once

#include <tuple>

#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/sim/tire_model.hpp"

namespace firstlap::sim {

enum class VehicleModel : int {
  single_track = 0,  // nonlinear tires, friction ellipse
  gym = 1,           // f1tenth_gym's linear tires, which never saturate; for conformance only
};

struct VehicleParams : CarDynamics {
  int model = 0;
  double step_dt = 0.0025;
  double mass = 3.5;
  double yaw_inertia = 0.0475;
  double l_f = 0.159;
  double l_r = 0.171;
  double cg_height = 0.06;
  double friction = 0.75;
  double front_b = 7.5;
  double front_c = 1.4;
  double front_d = 1.0;
  double front_e = 0.0;
  double rear_b = 7.5;
  double rear_c = 1.4;
  double rear_d = 1.0;
  double rear_e = 0.0;
  double drive_split = 0.5;
  double drive_grip = 0.9;
  double speed_constant_error = 0.0;
  double steering_gain = 1.0;
  double steering_trim = 0.0;
  double accel_max = 6.0;
  double speed_max = 12.0;
  double reverse_speed_max = 0.0;
  double kinematic_below = 0.8;
  double gym_stiffness_front = 4.718;
  double gym_stiffness_rear = 5.4562;
  double gym_switch_speed = 7.319;

  static constexpr auto fields() {
    using P = VehicleParams;
    const std::tuple own{
        Field{"model", &P::model, "", 0.0, 1.0, "0 single track with nonlinear tires, 1 f1tenth_gym's model"},
        Field{"step_dt", &P::step_dt, "s", 0.0001, 0.0025, "maximum integration step (Runge-Kutta 4)"},
        Field{"mass", &P::mass, "kg", 0.5, 5000.0, "mass of the car"},
        Field{"yaw_inertia", &P::yaw_inertia, "kg m^2", 0.001, 10000.0,
              "yaw moment of inertia about the center of gravity"},
        Field{"l_f", &P::l_f, "m", 0.02, 5.0, "center of gravity to front axle"},
        Field{"l_r", &P::l_r, "m", 0.02, 5.0, "center of gravity to rear axle"},
        Field{"cg_height", &P::cg_height, "m", 0.0, 2.0, "height of the center of gravity"},
        Field{"friction", &P::friction, "", 0.05, 3.0, "friction coefficient mu of the tires; also used by gym"},
        Field{"front_b", &P::front_b, "", 0.1, 100.0, "Pacejka B, front"},
        Field{"front_c", &P::front_c, "", 0.1, 5.0, "Pacejka C, front"},
        Field{"front_d", &P::front_d, "", 0.05, 3.0, "Pacejka D, front"},
        Field{"front_e", &P::front_e, "", -10.0, 1.0, "Pacejka E, front"},
        Field{"rear_b", &P::rear_b, "", 0.1, 100.0, "Pacejka B, rear"},
        Field{"rear_c", &P::rear_c, "", 0.1, 5.0, "Pacejka C, rear"},
        Field{"rear_d", &P::rear_d, "", 0.05, 3.0, "Pacejka D, rear"},
        Field{"rear_e", &P::rear_e, "", -10.0, 1.0, "Pacejka E, rear"},
        Field{"drive_split", &P::drive_split, "", 0.0, 1.0, "front share of driving and braking force"},
        Field{"drive_grip", &P::drive_grip, "", 0.1, 1.0, "share of an axle's grip available for driving and braking"},
        Field{"speed_constant_error", &P::speed_constant_error, "", -0.5, 0.5,
              "the true speed is 1 + this times the commanded and measured speed"},
        Field{"steering_gain", &P::steering_gain, "", 0.2, 3.0, "steering angle per commanded steering angle"},
        Field{"steering_trim", &P::steering_trim, "rad", -0.3, 0.3, "steering angle for a command of 0"},
        Field{"accel_max", &P::accel_max, "m/s^2", 0.1, 50.0, "acceleration limit of the motor"},
        Field{"speed_max", &P::speed_max, "m/s", 0.5, 100.0, "maximum speed command"},
        Field{"reverse_speed_max", &P::reverse_speed_max, "m/s", 0.0, 50.0,
              "maximum speed in reverse gear (0: no reverse gear)"},
        Field{"kinematic_below", &P::kinematic_below, "m/s", 0.1, 3.0,
              "kinematic model below this speed, blended up to 1.5 times this"},
        Field{"gym_stiffness_front", &P::gym_stiffness_front, "1/rad", 0.1, 100.0, "C_Sf of the gym model"},
        Field{"gym_stiffness_rear", &P::gym_stiffness_rear, "1/rad", 0.1, 100.0, "C_Sr of the gym model"},
        Field{"gym_switch_speed", &P::gym_switch_speed, "m/s", 0.1, 100.0,
              "gym: above this speed the acceleration falls as 1/v"},
    };
    return std::tuple_cat(CarDynamics::fields(), own);
  }

  Tire front_tire() const noexcept { return {front_b, front_c, front_d, front_e}; }
  Tire rear_tire() const noexcept { return {rear_b, rear_c, rear_d, rear_e}; }
};

}  // namespace firstlap::sim
