// The words that every room shares. SI units; frames after REP 103/105: x forward, y left, angles
// counter-clockwise positive, steering left positive.
#pragma once

#include <cstdint>
#include <span>

namespace firstlap {

struct Point2 {
  double x = 0.0;
  double y = 0.0;
};

struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
};

// One sweep of a planar LiDAR, as sensor_msgs/LaserScan. A view: the ranges belong to the caller.
// Beams run counter-clockwise when angle_increment > 0. A range that is not finite, or outside
// (range_min, range_max), is "no return" (REP 117), never a point at that range.
struct LaserScan {
  double angle_min = 0.0;        // [rad] of the first beam, in the laser's frame
  double angle_increment = 0.0;  // [rad] between beams
  double time_increment = 0.0;   // [s] between beams; 0 when all beams belong to one moment
  double range_min = 0.0;        // [m]
  double range_max = 0.0;        // [m]
  std::span<const float> ranges{};
};

// What the car measures about itself at the end of the sweep.
struct VehicleState {
  double speed = 0.0;           // [m/s] along base_link x
  double yaw_rate = 0.0;        // [rad/s]
  double steering_angle = 0.0;  // [rad] of the front wheels
};

// Field names of ackermann_msgs/AckermannDrive.
struct DriveCommand {
  double speed = 0.0;           // [m/s]
  double steering_angle = 0.0;  // [rad]
};

// One point of the planned path, in base_link.
struct TrajectoryPoint {
  double s = 0.0;          // [m] arc length from the path's start
  double x = 0.0;          // [m]
  double y = 0.0;          // [m]
  double yaw = 0.0;        // [rad]
  double curvature = 0.0;  // [1/m], > 0 turns left
  double velocity = 0.0;   // [m/s]
};

// Why the command is what it is.
enum class Status : std::uint8_t {
  ok,         // planned from this scan
  holding,    // no path from this scan: the previous one, moved by odometry, for a short while
  no_path,    // nothing to follow: braking to a stop
  blocked,    // something stands on the path: braking to a stop before it
  bad_scan,   // the scan is empty or its header makes no sense: braking to a stop
  bad_state,  // the measured state is not finite or absurd: braking to a stop
};

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
};

}  // namespace firstlap
