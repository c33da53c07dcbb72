// Types shared by all layers. SI units; frames follow REP 103 and REP 105: x forward, y left, angles counterclockwise
// positive, steering left positive.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <tuple>

#include "firstlap/common/field.hpp"

namespace firstlap {

struct Point2 {
  double x = 0.0;
  double y = 0.0;

  static constexpr auto columns() {
    using C = Point2;
    return std::tuple{Column{"x", &C::x, "m", "forward"}, Column{"y", &C::y, "m", "left"}};
  }
};

struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  static constexpr auto columns() {
    using C = Pose2;
    return std::tuple{
        Column{"x", &C::x, "m", "forward, or east in a map"},
        Column{"y", &C::y, "m", "left, or north in a map"},
        Column{"yaw", &C::yaw, "rad", "counterclockwise"},
    };
  }
};

// One sweep of a planar LiDAR, as sensor_msgs/LaserScan. A view: the caller owns the ranges. Beams run counterclockwise
// if angle_increment > 0. A range that is not finite, or outside (range_min, range_max), is "no return" (REP 117),
// never a point at that range.
struct LaserScan {
  double angle_min = 0.0;
  double angle_increment = 0.0;
  double time_increment = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  std::span<const float> ranges{};  // [m] range of each beam

  // The header: all but the ranges.
  static constexpr auto columns() {
    using C = LaserScan;
    return std::tuple{
        Column{"angle_min", &C::angle_min, "rad",
               "direction of the first beam, in the frame of a LiDAR that faces forward"},
        Column{"angle_increment", &C::angle_increment, "rad", "between beams, > 0 counterclockwise"},
        Column{"time_increment", &C::time_increment, "s", "between beams; 0: all beams are measured at the same time"},
        Column{"range_min", &C::range_min, "m", "shorter ranges are no return"},
        Column{"range_max", &C::range_max, "m", "longer ranges are no return"},
    };
  }
};

// State measured by the car at the end of the sweep.
struct VehicleState {
  double speed = 0.0;
  double yaw_rate = 0.0;
  double steering_angle = 0.0;

  static constexpr auto columns() {
    using C = VehicleState;
    return std::tuple{
        Column{"speed", &C::speed, "m/s", "along base_link x"},
        Column{"yaw_rate", &C::yaw_rate, "rad/s", "left positive"},
        Column{"steering_angle", &C::steering_angle, "rad", "of the front wheels, left positive"},
    };
  }
};

// Measurements of the car's own sensors, from which an estimator derives a VehicleState. A value that is not finite was
// not measured.
struct SensorReading {
  double wheel_speed = 0.0;
  double yaw_rate = 0.0;
  double steering_angle = 0.0;
  double acceleration_x = 0.0;
  double acceleration_y = 0.0;

  static constexpr auto columns() {
    using C = SensorReading;
    return std::tuple{
        Column{"wheel_speed", &C::wheel_speed, "m/s", "speed of the wheels' circumference"},
        Column{"yaw_rate", &C::yaw_rate, "rad/s", "of the gyro, left positive"},
        Column{"steering_angle", &C::steering_angle, "rad", "of the servo, left positive"},
        Column{"acceleration_x", &C::acceleration_x, "m/s^2", "of the accelerometer, forward"},
        Column{"acceleration_y", &C::acceleration_y, "m/s^2", "of the accelerometer, to the left"},
    };
  }
};

// The measured values as the state, for drivers of cars without an estimate.
constexpr VehicleState as_measured(const SensorReading& reading) noexcept {
  return {reading.wheel_speed, reading.yaw_rate, reading.steering_angle};
}

// Field names as in ackermann_msgs/AckermannDrive.
struct DriveCommand {
  double speed = 0.0;
  double steering_angle = 0.0;

  static constexpr auto columns() {
    using C = DriveCommand;
    return std::tuple{
        Column{"speed", &C::speed, "m/s", "commanded"},
        Column{"steering_angle", &C::steering_angle, "rad", "commanded, left positive"},
    };
  }
};

// One point of the planned path, in base_link.
struct TrajectoryPoint {
  double s = 0.0;
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  double curvature = 0.0;
  double velocity = 0.0;

  static constexpr auto columns() {
    using C = TrajectoryPoint;
    return std::tuple{
        Column{"s", &C::s, "m", "arc length from the start of the path"},
        Column{"x", &C::x, "m", "base_link"},
        Column{"y", &C::y, "m", "base_link"},
        Column{"yaw", &C::yaw, "rad", "heading of the path"},
        Column{"curvature", &C::curvature, "1/m", "> 0 turns left"},
        Column{"velocity", &C::velocity, "m/s", "planned"},
    };
  }
};

// Reason for a command.
enum class Status : std::uint8_t {
  ok,         // planned from this scan
  holding,    // no path from this scan: the previous one, moved by odometry, for up to hold_time
  no_path,    // no path: braking to a stop
  blocked,    // an obstacle is on the path: braking to a stop before it
  bad_scan,   // the scan is empty or its header is invalid: braking to a stop
  bad_state,  // the measured state is not finite or implausible: braking to a stop
};

inline constexpr std::array statuses{Status::ok,      Status::holding,  Status::no_path,
                                     Status::blocked, Status::bad_scan, Status::bad_state};

constexpr const char* to_string(Status status) noexcept {
  switch (status) {
    case Status::ok: return "ok";
    case Status::holding: return "holding";
    case Status::no_path: return "no_path";
    case Status::blocked: return "blocked";
    case Status::bad_scan: return "bad_scan";
    case Status::bad_state: return "bad_state";
  }
  return "unknown";
}

struct StepResult {
  DriveCommand command{};
  Status status = Status::no_path;

  static constexpr auto columns() {
    using C = StepResult;
    return std::tuple{
        Part{&C::command},
        Column{"status", &C::status, "", "reason for the command"},
    };
  }
};

}  // namespace firstlap
