// The simulated car. Internally the state is that of the center of gravity; the interface uses base_link (center of the
// rear axle), as everywhere. Map frame, SI units, left positive.
#pragma once

#include <array>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/delay_line.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/vehicle_params.hpp"

namespace firstlap::sim {

// State of the center of gravity of the single_track model: x, y [m], yaw [rad], forward and lateral speed in the body
// frame [m/s], yaw rate [rad/s], steering angle [rad].
struct BodyState {
  double x = 0.0, y = 0.0, yaw = 0.0;
  double forward = 0.0, lateral = 0.0, yaw_rate = 0.0;
  double steering = 0.0;
};

// Derivative of the single-track model at `state`, for commands of speed [m/s] and steering angle [rad].
BodyState single_track_derivative(const CarGeometry& geometry, const VehicleParams& params, const BodyState& state,
                                  double speed_command, double steering_command) noexcept;

// f1tenth_gym's single-track model (from CommonRoad): state [x, y, steering, v, yaw, yaw rate, slip angle] of the
// center of gravity, input [steering rate, acceleration], limited internally. Kinematic below 0.5 m/s.
using GymState = std::array<double, 7>;
struct GymInput {
  double steering_rate = 0.0;  // [rad/s]
  double acceleration = 0.0;   // [m/s^2]
};
GymState gym_derivative(const CarGeometry& geometry, const VehicleParams& params, const GymState& state,
                        const GymInput& input) noexcept;

// f1tenth_gym's low-level control: bang-bang steering, proportional speed (gains 4.755 up and 19.02 down with its
// parameters).
GymInput gym_control(const CarGeometry& geometry, const VehicleParams& params, const GymState& state,
                     double speed_command, double steering_command) noexcept;

// The pose at the fraction `t` (0 to 1) between `a` and `b`.
Pose2 between(const Pose2& a, const Pose2& b, double t) noexcept;

class Vehicle {
 public:
  // Throws std::invalid_argument for a parameter outside its range, or if l_f + l_r is not the wheelbase.
  Vehicle(const CarGeometry& geometry, const VehicleParams& params);

  // Places the car at `base_link`, rolling straight at `speed` [m/s]; clears commands and time.
  void reset(const Pose2& base_link, double speed = 0.0);

  // Gives a command now. It takes effect after `latency` [s] plus the car's own delays. Ignored if not finite.
  void command(const DriveCommand& command, double latency = 0.0) noexcept;

  // Changes the parameters from now on; pose and motion of base_link continue. Throws std::invalid_argument as the
  // constructor does, and for another model; then nothing changes.
  void change(const CarGeometry& geometry, const VehicleParams& params);

  // A disturbance: adds to the lateral speed [m/s] of the center of gravity and to the yaw rate [rad/s]. Ignored if not
  // finite.
  void kick(double lateral_speed, double yaw_rate) noexcept;

  // Advances by dt [s], at most params.step_dt.
  void step(double dt) noexcept;

  Pose2 pose() const noexcept;              // base_link in the map frame
  VehicleState state() const noexcept;      // true, at base_link
  VehicleState own_state() const noexcept;  // as measured by the car's electronics with their constants
  double lateral_speed() const noexcept;    // [m/s] at base_link
  double forward_acceleration() const noexcept { return a_x_; }  // [m/s^2] of the center of gravity
  double lateral_acceleration() const noexcept { return a_y_; }  // [m/s^2] of the center of gravity
  Point2 acceleration_at(double x) const noexcept;               // [m/s^2] of a point `x` [m] ahead of the rear axle
  double time() const noexcept { return time_; }                 // [s] since reset

 private:
  void step_single_track(double dt) noexcept;
  void step_gym(double dt) noexcept;
  void update_gym_input() noexcept;

  CarGeometry geometry_;
  VehicleParams params_;
  BodyState body_{};
  DelayLine steering_line_, speed_line_;
  double time_ = 0.0, a_x_ = 0.0, a_y_ = 0.0, yaw_acceleration_ = 0.0;
  GymState gym_{};
  GymInput gym_input_{};
  std::array<double, 2> gym_buffer_{};
  double gym_next_control_ = 0.0;
};

}  // namespace firstlap::sim
