#include "firstlap/sim/vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <utility>

#include "firstlap/common/rng.hpp"
#include "firstlap/sim/car.hpp"

namespace firstlap::sim {
namespace {

constexpr double g = 9.81;
constexpr double dt = 0.0025;

Vehicle driven(const Car& car, DriveCommand command, double seconds) {
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.command(command);
  for (int i = 0; i < static_cast<int>(seconds / dt); ++i) vehicle.step(dt);
  return vehicle;
}

TEST(Vehicle, pacejka_peaks_at_d_and_is_odd) {
  const Tire tire{7.5, 1.4, 0.9, 0.2};
  double peak = 0.0;
  for (double a = 0.0; a < 1.5; a += 1e-4) {
    peak = std::max(peak, magic_formula(tire, a));
    ASSERT_DOUBLE_EQ(magic_formula(tire, -a), -magic_formula(tire, a));
  }
  EXPECT_NEAR(peak, 0.9, 1e-6);
  EXPECT_NEAR(magic_formula(tire, 1e-6) / 1e-6, 7.5 * 1.4 * 0.9, 1e-3);
}

TEST(Vehicle, conforms_to_the_common_road_single_track_vector) {
  CarGeometry geometry;  // BMW 320i, f1tenth_gym's unit test
  geometry.steering_limit = 1.066;
  geometry.steering_rate = 0.4;
  VehicleParams p = gym_car().vehicle;
  p.friction = 1.0489;
  p.gym_stiffness_front = p.gym_stiffness_rear = 21.92 / 1.0489;
  p.l_f = 0.3048 * 3.793293;
  p.l_r = 0.3048 * 4.667707;
  p.cg_height = 0.3048 * 2.01355;
  p.mass = 4.4482216152605 / 0.3048 * 74.91452;
  p.yaw_inertia = 4.4482216152605 * 0.3048 * 1321.416;
  p.accel_max = p.brake_max = 11.5;
  p.speed_max = 50.8;
  p.reverse_speed_max = 13.6;
  const GymState state{2.0233348142065677, 0.0041907137716636, 0.0197545248559617, 15.7216236334290116,
                       0.0025857914776859, 0.0529001056654038, 0.0033012170610298};
  const GymState expected{15.7213512030862397, 0.0925527979719355, 0.15, 5.3536773276413925, 0.0529001056654038,
                          0.6435589397748606,  0.0313297971641291};
  const GymState f = gym_derivative(geometry, p, state, {0.15, 0.63 * g});
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_NEAR(f[i], expected[i], 1e-12) << i;
}

// The state of its electronics agrees with the command; the true motion does not.
TEST(Vehicle, wrong_constants_change_only_the_true_motion) {
  // f1tenth_gym's servo turns at full rate or not at all, and stays within this error [rad].
  constexpr double gym_servo = 2e-3;
  for (const auto& [preset, servo] : {std::pair{default_car(), 0.0}, {gym_car(), gym_servo}}) {
    Car car = preset;
    car.vehicle.speed_constant_error = 0.15;
    car.vehicle.steering_gain = 0.8;
    car.vehicle.steering_trim = 0.05;
    const Vehicle vehicle = driven(car, {2.0, 0.1}, 4.0);
    EXPECT_NEAR(vehicle.state().steering_angle, 0.8 * 0.1 + 0.05, servo + 1e-9);
    EXPECT_NEAR(vehicle.own_state().steering_angle, 0.1, servo / 0.8 + 1e-9);
    EXPECT_NEAR(vehicle.state().speed, 2.3, 0.05);
    EXPECT_NEAR(vehicle.own_state().speed, vehicle.state().speed / 1.15, 1e-12);
    EXPECT_EQ(vehicle.own_state().yaw_rate, vehicle.state().yaw_rate);
  }
}

TEST(Car, the_lidar_pose_includes_its_mounting_errors) {
  Car car;
  const Pose2 base{1.0, 2.0, std::numbers::pi / 2.0};
  Pose2 laser = laser_pose(car, base);
  EXPECT_NEAR(laser.x, 1.0, 1e-12);
  EXPECT_NEAR(laser.y, 2.0 + car.geometry.laser_x, 1e-12);
  car.sensors.laser_x_error = 0.1;
  car.sensors.laser_y_error = 0.02;
  car.sensors.laser_yaw_error = 0.3;
  laser = laser_pose(car, base);
  EXPECT_NEAR(laser.x, 1.0 - 0.02, 1e-12);
  EXPECT_NEAR(laser.y, 2.1 + car.geometry.laser_x, 1e-12);
  EXPECT_NEAR(laser.yaw, base.yaw + 0.3, 1e-12);
}

TEST(Vehicle, gym_control_has_its_two_speed_gains) {
  const Car car = gym_car();
  const GymState at_two{0, 0, 0, 2.0, 0, 0, 0};
  EXPECT_NEAR(gym_control(car.geometry, car.vehicle, at_two, 3.0, 0.1).acceleration, 4.755, 1e-12);
  EXPECT_NEAR(gym_control(car.geometry, car.vehicle, at_two, 1.0, 0.1).acceleration, -19.02, 1e-12);
  EXPECT_EQ(gym_control(car.geometry, car.vehicle, at_two, 1.0, 0.1).steering_rate, 3.2);
  EXPECT_EQ(gym_control(car.geometry, car.vehicle, at_two, 1.0, 0.00005).steering_rate, 0.0);
}

TEST(Vehicle, gym_steers_two_control_steps_late) {
  const Car car = gym_car();
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.command({0.0, 0.4});
  for (int i = 0; i < 8; ++i) vehicle.step(dt);
  EXPECT_EQ(vehicle.state().steering_angle, 0.0);
  vehicle.step(dt);
  EXPECT_NEAR(vehicle.state().steering_angle, 3.2 * dt, 1e-12);
}

// delta = L / R + a_y / (g mu) (1 / BCD_f - 1 / BCD_r) while the tires are in their linear range.
void expect_steady_cornering(const Car& car, double speed, double steering) {
  const Vehicle vehicle = driven(car, {speed, steering}, 8.0);
  const double yaw_rate = vehicle.state().yaw_rate, v = vehicle.state().speed, a_y = vehicle.lateral_acceleration();
  const VehicleParams& p = car.vehicle;
  const double front = p.friction * p.front_b * p.front_c * p.front_d;
  const double understeer = 1.0 / front - 1.0 / (p.friction * p.rear_b * p.rear_c * p.rear_d);
  EXPECT_NEAR(car.geometry.wheelbase * yaw_rate / v + understeer * a_y / g, steering, 0.01 * steering);
  EXPECT_NEAR(a_y, v * yaw_rate, 1e-3);
}

TEST(Vehicle, steady_state_cornering_matches_the_closed_form) {
  expect_steady_cornering(default_car(), 2.0, 0.05);
  expect_steady_cornering(default_car(), 3.0, 0.03);
  expect_steady_cornering(nuc2_car(), 2.0, 0.05);
  expect_steady_cornering(nuc2_car(), 3.0, 0.03);
}

TEST(Vehicle, is_kinematic_when_slow) {
  const Vehicle vehicle = driven(default_car(), {0.5, 0.3}, 5.0);
  EXPECT_NEAR(vehicle.state().yaw_rate, vehicle.state().speed * std::tan(0.3) / 0.33, 1e-6);
  EXPECT_NEAR(vehicle.lateral_speed(), 0.0, 1e-6);
}

TEST(Vehicle, rear_axle_follows_the_kinematic_circle) {
  const Car car = default_car();
  Vehicle vehicle = driven(car, {0.5, 0.3}, 5.0);
  const double radius = car.geometry.wheelbase / std::tan(0.3);
  const Pose2 start = vehicle.pose();
  const Point2 center{start.x - radius * std::sin(start.yaw), start.y + radius * std::cos(start.yaw)};
  for (int i = 0; i < 4000; ++i) {
    vehicle.step(dt);
    ASSERT_NEAR(std::hypot(vehicle.pose().x - center.x, vehicle.pose().y - center.y), radius, 1e-4);
  }
}

TEST(Vehicle, never_accelerates_beyond_its_friction) {
  Rng rng(31);
  for (const Car& car : {default_car(), nuc2_car()}) {
    const double peak = std::max(car.vehicle.front_d, car.vehicle.rear_d);
    for (int trial = 0; trial < 40; ++trial) {
      Vehicle vehicle(car.geometry, car.vehicle);
      double largest = 0.0;
      for (int i = 0; i < 4000; ++i) {
        if (i % 80 == 0) vehicle.command({12.0 * rng.uniform(), 0.9 * (rng.uniform() - 0.5)});
        vehicle.step(dt);
        ASSERT_TRUE(std::isfinite(vehicle.pose().x));
        if (std::hypot(vehicle.state().speed, vehicle.lateral_speed()) < 2.0) continue;
        largest = std::max(largest, std::hypot(vehicle.forward_acceleration(), vehicle.lateral_acceleration()));
      }
      ASSERT_LE(largest, car.vehicle.friction * peak * g * 1.0001);
    }
  }
}

TEST(Vehicle, brakes_at_its_limit_with_enough_grip) {
  Car car = default_car();
  car.vehicle.brake_max = 4.0;
  car.vehicle.speed_gain = 100.0;
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.reset({}, 6.0);
  vehicle.command({0.0, 0.0});
  for (int i = 0; i < 1200; ++i) vehicle.step(dt);
  EXPECT_NEAR(vehicle.pose().x, 6.0 * 6.0 / (2.0 * 4.0), 0.01);
  EXPECT_NEAR(vehicle.state().speed, 0.0, 1e-6);
}

TEST(Vehicle, braking_is_limited_by_grip) {
  Car car = default_car();
  car.vehicle.brake_max = 50.0;
  car.vehicle.friction = 0.3;
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.reset({}, 6.0);
  vehicle.command({0.0, 0.0});
  for (int i = 0; i < 2400; ++i) vehicle.step(dt);
  EXPECT_GT(vehicle.pose().x, 6.0 * 6.0 / (2.0 * 0.3 * g));
  EXPECT_LT(vehicle.pose().x, 1.3 * 6.0 * 6.0 / (2.0 * 0.3 * g));
}

TEST(Vehicle, servo_keeps_its_rate_lag_and_delay) {
  const Car car = default_car();
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.command({0.0, 1.0});  // beyond the limit
  double before = 0.0, fastest = 0.0;
  for (int i = 0; i < 400; ++i) {
    vehicle.step(dt);
    const double now = vehicle.state().steering_angle;
    fastest = std::max(fastest, (now - before) / dt);
    ASSERT_EQ(now > 0.0, vehicle.time() > 0.04 + 1e-9);
    before = now;
  }
  EXPECT_NEAR(fastest, 3.2, 1e-9);
  EXPECT_NEAR(before, car.geometry.steering_limit, 1e-4);
}

TEST(Vehicle, servo_small_step_is_first_order) {
  Car car = default_car();
  car.vehicle.steering_delay = 0.0;
  Vehicle vehicle(car.geometry, car.vehicle);
  vehicle.command({0.0, 0.1});
  for (int i = 0; i < 24; ++i) vehicle.step(dt);  // one time constant
  EXPECT_NEAR(vehicle.state().steering_angle, 0.1 * (1.0 - std::exp(-1.0)), 1e-6);
}

TEST(Vehicle, cannot_reverse) {
  const Vehicle vehicle = driven(default_car(), {-3.0, 0.1}, 2.0);
  EXPECT_EQ(vehicle.state().speed, 0.0);
}

TEST(Vehicle, ignores_a_command_that_is_not_finite) {
  Vehicle vehicle = driven(default_car(), {2.0, 0.1}, 2.0);
  const double speed = vehicle.state().speed;
  vehicle.command({NAN, 0.0});
  vehicle.command({1.0, INFINITY});
  for (int i = 0; i < 400; ++i) vehicle.step(dt);
  EXPECT_NEAR(vehicle.state().speed, speed, 0.01);
}

TEST(Vehicle, halving_the_step_changes_little) {
  const Car car = default_car();
  Vehicle coarse(car.geometry, car.vehicle), fine(car.geometry, car.vehicle);
  for (int i = 0; i < 2000; ++i) {
    if (i % 200 == 0) {
      coarse.command({4.0, i % 400 == 0 ? 0.2 : -0.2});
      fine.command({4.0, i % 400 == 0 ? 0.2 : -0.2});
    }
    coarse.step(dt);
    fine.step(0.5 * dt);
    fine.step(0.5 * dt);
  }
  EXPECT_NEAR(coarse.pose().x, fine.pose().x, 2e-3);
  EXPECT_NEAR(coarse.pose().y, fine.pose().y, 2e-3);
}

// In a steady circle every point accelerates toward the center: a_x = -r u - x r^2, a_y = r v, x ahead of the rear
// axle.
TEST(Vehicle, acceleration_ahead_of_the_rear_axle_includes_the_turn) {
  const Vehicle vehicle = driven(default_car(), {2.0, 0.2}, 6.0);
  const VehicleState state = vehicle.state();
  const double r = state.yaw_rate;
  for (const double x : {0.0, 0.171, 0.4}) {
    const Point2 acceleration = vehicle.acceleration_at(x);
    EXPECT_NEAR(acceleration.x, -r * vehicle.lateral_speed() - x * r * r, 0.02);
    EXPECT_NEAR(acceleration.y, r * state.speed, 0.02);
  }
}

TEST(Vehicle, rejects_axles_that_contradict_the_wheelbase) {
  Car car = default_car();
  car.vehicle.l_f = 0.3;
  EXPECT_THROW(Vehicle(car.geometry, car.vehicle), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
