// The cars that can be simulated.
#pragma once

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/estimation/state_estimate_params.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/sensors.hpp"
#include "firstlap/sim/vehicle.hpp"
#include "firstlap/sim/vehicle_params.hpp"

namespace firstlap::sim {

struct Car {
  CarGeometry geometry{};
  VehicleParams vehicle{};
  SensorParams sensors{};
  StateEstimateParams state_estimate{};
  LidarParams lidar{};
};

// The part of the car that drivers and estimators know.
CarModel model_of(const Car& car) noexcept;

// The true motion that the car's sensors measure.
SensedMotion sensed(const Vehicle& vehicle, const Car& car) noexcept;

// Pose of the LiDAR, including its mounting errors, in the frame of `base_link`.
Pose2 laser_pose(const Car& car, const Pose2& base_link) noexcept;

Car default_car();
Car nuc2_car();  // ForzaETH's NUC2, with identified parameters
Car gym_car();   // f1tenth_gym's car: linear tires and its scan; for conformance tests, not for lap times

}  // namespace firstlap::sim
