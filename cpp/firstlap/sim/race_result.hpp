// What a race leaves behind. Map frame, SI units, base_link.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "firstlap/common/types.hpp"

namespace firstlap::sim {

enum class Outcome : std::uint8_t { running, finished, contact, stuck, timeout, wrong_way };

constexpr const char* to_string(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::running: return "running";
    case Outcome::finished: return "finished";
    case Outcome::contact: return "contact";
    case Outcome::stuck: return "stuck";
    case Outcome::timeout: return "timeout";
    case Outcome::wrong_way: return "wrong_way";
  }
  return "unknown";
}

struct Lap {
  double time = 0.0;           // [s] line to line
  double distance = 0.0;       // [m] driven by base_link
  double mean_speed = 0.0;     // [m/s] distance / time
  double max_speed = 0.0;      // [m/s]
  double min_clearance = 0.0;  // [m] car to nearest solid wall
  double rms_offset = 0.0;     // [m] from the centerline, over time
  bool standing = false;       // started from standstill
};

struct Contact {
  double time = 0.0;        // [s] since the start
  double x = 0.0, y = 0.0;  // [m] on the wall
  double s = 0.0;           // [m] of base_link along the centerline
  bool obstacle = false;    // it was the sudden obstacle, not a wall
};

// The sudden obstacle, once it has appeared.
struct ObstacleSeen {
  double time = 0.0;       // [s] it appeared
  Pose2 middle{};          // [m], [rad]
  double speed = 0.0;      // [m/s] of the car at that time
  double yaw_rate = 0.0;   // [rad/s]
  double clearance = 0.0;  // [m] smallest distance between car and box since
};

// At each scan instant, the true state and the command the driver gave for it.
struct PathSample {
  double time = 0.0;                    // [s]
  double x = 0.0, y = 0.0, yaw = 0.0;   // [m], [rad]
  double speed = 0.0;                   // [m/s]
  double yaw_rate = 0.0;                // [rad/s]
  double steering_angle = 0.0;          // [rad]
  double s = 0.0;                       // [m]
  double lateral_offset = 0.0;          // [m] left positive
  double command_speed = 0.0;           // [m/s]
  double command_steering_angle = 0.0;  // [rad]
  Status status = Status::ok;
};

struct RaceResult {
  Outcome outcome = Outcome::running;
  double time = 0.0;      // [s] simulated so far
  double distance = 0.0;  // [m] driven so far
  std::vector<Lap> laps;
  std::optional<Contact> contact;
  std::optional<ObstacleSeen> obstacle;
  std::vector<float> compute_times;  // [us] of each driver step, by its thread's CPU clock
  long skipped_scans = 0;            // which the driver never saw, because it was busy
  std::vector<PathSample> path;      // empty unless options.record_path
};

}  // namespace firstlap::sim
