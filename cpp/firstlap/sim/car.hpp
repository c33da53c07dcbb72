// The cars one can simulate.
#pragma once

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/sensors.hpp"
#include "firstlap/sim/vehicle_params.hpp"

namespace firstlap::sim {

struct Car {
  CarGeometry geometry{};
  VehicleParams vehicle{};
  SensorParams sensors{};
  LidarParams lidar{};
};

// Where the laser is, in the frame in which `base_link` is given, its mounting errors included.
Pose2 laser_pose(const Car& car, const Pose2& base_link) noexcept;

Car default_car();
Car nuc2_car();  // ForzaETH's NUC2, identified on track
Car gym_car();   // f1tenth_gym's: linear tires, its scan; for conformance, not for lap-time claims

}  // namespace firstlap::sim
