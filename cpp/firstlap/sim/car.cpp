#include "firstlap/sim/car.hpp"

#include <cmath>

namespace firstlap::sim {

Pose2 laser_pose(const Car& car, const Pose2& base_link) noexcept {
  const double x = car.geometry.laser_x + car.sensors.laser_x_error;
  const double y = car.geometry.laser_y + car.sensors.laser_y_error;
  const double c = std::cos(base_link.yaw);
  const double s = std::sin(base_link.yaw);
  return {base_link.x + c * x - s * y, base_link.y + s * x + c * y, base_link.yaw + car.sensors.laser_yaw_error};
}

CarModel model_of(const Car& car) noexcept { return {car.geometry, car.vehicle}; }

SensedMotion sensed(const Vehicle& vehicle, const Car& car) noexcept {
  return {vehicle.own_state(), vehicle.pose().yaw, vehicle.acceleration_at(car.sensors.imu_x),
          vehicle.forward_acceleration()};
}

Car default_car() { return {}; }

// ForzaETH race_stack, stack_master/config/NUC2 (2024). The servo's time constant was identified including its delay,
// so no delay is added. Motor limits and sensors are those of the default car.
Car nuc2_car() {
  Car car;
  car.geometry.wheelbase = 0.307;
  VehicleParams& v = car.vehicle;
  v.mass = 3.54;
  v.yaw_inertia = 0.05797;
  v.l_f = 0.162;
  v.l_r = 0.145;
  v.cg_height = 0.014;
  v.friction = 1.0;
  v.front_b = 4.7985;
  v.front_c = 2.1640;
  v.front_d = 0.6502;
  v.front_e = 0.3732;
  v.rear_b = 20.0;
  v.rear_c = 1.5;
  v.rear_d = 0.6184;
  v.servo_time_constant = 0.1578;
  v.steering_delay = 0.0;
  return car;
}

// f1tenth_gym's default parameters, with the LiDAR of f1tenth_gym_ros and a state without noise. Its rectangle is
// centered on the center of gravity.
Car gym_car() {
  Car car;
  car.geometry.wheelbase = 0.3302;
  car.geometry.rear_overhang = 0.11855;
  car.geometry.laser_x = 0.275;
  VehicleParams& v = car.vehicle;
  v.model = static_cast<int>(VehicleModel::gym);
  v.mass = 3.74;
  v.yaw_inertia = 0.04712;
  v.l_f = 0.15875;
  v.l_r = 0.17145;
  v.cg_height = 0.074;
  v.friction = 1.0489;
  v.accel_max = v.brake_max = 9.51;
  v.speed_max = 20.0;
  v.reverse_speed_max = 5.0;
  v.steering_delay = 0.0;
  car.sensors = {
      .speed_noise = 0.0, .yaw_rate_noise = 0.0, .steering_noise = 0.0, .acceleration_noise = 0.0, .vibration = 0.0};
  LidarParams& lidar = car.lidar;
  lidar.beams = 1080;
  lidar.fov = 4.7;
  lidar.range_min = 0.0;
  lidar.sweep_time = 0.0;
  lidar.dropout_rate = 0.0;
  return car;
}

}  // namespace firstlap::sim
