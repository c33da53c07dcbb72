// The result of a race. Map frame, SI units, base_link.
#pragma once

#include <cstdint>
#include <optional>
#include <tuple>
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
  double time = 0.0;
  double distance = 0.0;
  double mean_speed = 0.0;
  double max_speed = 0.0;
  double min_clearance = 0.0;
  double rms_offset = 0.0;
  bool standing = false;

  static constexpr auto columns() {
    using C = Lap;
    return std::tuple{
        Column{"time", &C::time, "s", "line to line"},
        Column{"distance", &C::distance, "m", "traveled by base_link"},
        Column{"mean_speed", &C::mean_speed, "m/s", "distance over time"},
        Column{"max_speed", &C::max_speed, "m/s", "highest"},
        Column{"min_clearance", &C::min_clearance, "m", "from the car to the nearest solid wall"},
        Column{"rms_offset", &C::rms_offset, "m", "from the centerline, over time"},
        Column{"standing", &C::standing, "", "started from standstill"},
    };
  }
};

struct Contact {
  double time = 0.0;
  double x = 0.0, y = 0.0;
  double s = 0.0;
  bool obstacle = false;

  static constexpr auto columns() {
    using C = Contact;
    return std::tuple{
        Column{"time", &C::time, "s", "since the start"},
        Column{"x", &C::x, "m", "of the contact point, map frame"},
        Column{"y", &C::y, "m", "of the contact point, map frame"},
        Column{"s", &C::s, "m", "of base_link along the centerline"},
        Column{"obstacle", &C::obstacle, "", "contact with the sudden obstacle, not with a wall"},
    };
  }
};

// The sudden obstacle, once it has appeared.
struct ObstacleSeen {
  double time = 0.0;
  Pose2 middle{};
  double speed = 0.0;
  double yaw_rate = 0.0;
  double clearance = 0.0;

  static constexpr auto columns() {
    using C = ObstacleSeen;
    return std::tuple{
        Column{"time", &C::time, "s", "when it appeared"},
        Part{&C::middle},
        Column{"speed", &C::speed, "m/s", "of the car at that time"},
        Column{"yaw_rate", &C::yaw_rate, "rad/s", "of the car at that time"},
        Column{"clearance", &C::clearance, "m", "smallest distance between car and obstacle since then"},
    };
  }
};

// True state at each scan, and the driver's command for it.
struct PathSample {
  double time = 0.0;
  double x = 0.0, y = 0.0, yaw = 0.0;
  double speed = 0.0;
  double yaw_rate = 0.0;
  double steering_angle = 0.0;
  double s = 0.0;
  double lateral_offset = 0.0;
  double command_speed = 0.0;
  double command_steering_angle = 0.0;
  Status status = Status::ok;

  static constexpr auto columns() {
    using C = PathSample;
    return std::tuple{
        Column{"time", &C::time, "s", "since the start"},
        Column{"x", &C::x, "m", "of base_link, map frame"},
        Column{"y", &C::y, "m", "of base_link, map frame"},
        Column{"yaw", &C::yaw, "rad", "of base_link, map frame"},
        Column{"speed", &C::speed, "m/s", "true"},
        Column{"yaw_rate", &C::yaw_rate, "rad/s", "true"},
        Column{"steering_angle", &C::steering_angle, "rad", "true"},
        Column{"s", &C::s, "m", "arc length along the centerline"},
        Column{"lateral_offset", &C::lateral_offset, "m", "from the centerline, left positive"},
        Column{"command_speed", &C::command_speed, "m/s", "for this scan"},
        Column{"command_steering_angle", &C::command_steering_angle, "rad", "for this scan"},
        Column{"status", &C::status, "", "of the command, an index into the list of statuses"},
    };
  }
};

struct RaceResult {
  Outcome outcome = Outcome::running;
  double time = 0.0;
  double distance = 0.0;
  std::vector<Lap> laps;
  std::optional<Contact> contact;
  std::optional<ObstacleSeen> obstacle;
  std::vector<float> compute_times;
  long skipped_scans = 0;
  std::vector<PathSample> path;

  static constexpr auto columns() {
    using C = RaceResult;
    return std::tuple{
        Column{"outcome", &C::outcome, "", "running, finished, contact, stuck, timeout or wrong_way"},
        Column{"time", &C::time, "s", "simulated time"},
        Column{"distance", &C::distance, "m", "distance driven"},
        Column{"laps", &C::laps, "", "completed laps"},
        Column{"contact", &C::contact, "", "contact that ended the race, if any"},
        Column{"skipped_scans", &C::skipped_scans, "", "number of scans skipped because the driver was busy"},
        Column{"obstacle", &C::obstacle, "", "the sudden obstacle, once it has appeared"},
        Column{"compute_times", &C::compute_times, "us", "CPU time of each driver step"},
        Column{"path", &C::path, "", "one row per scan; empty unless options.record_path"},
    };
  }
};

}  // namespace firstlap::sim
