// One car on one track with one driver, for some laps. The race is stepped scan by scan; the same seed gives the same
// race, bit for bit. The driver processes one scan at a time: while it is busy, the newest scan waits, older ones are
// skipped, and its command takes effect when it is done.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "firstlap/common/driver.hpp"
#include "firstlap/common/field.hpp"
#include "firstlap/estimation/state_estimate.hpp"
#include "firstlap/sim/car.hpp"
#include "firstlap/sim/lap_meter.hpp"
#include "firstlap/sim/obstacle.hpp"
#include "firstlap/sim/progress.hpp"
#include "firstlap/sim/race_result.hpp"
#include "firstlap/sim/vehicle.hpp"
#include "firstlap/sim/walls.hpp"

namespace firstlap::sim {

struct Track {
  Walls walls;
  std::vector<Point2> centerline;  // [m] closed, in the direction of travel, first point not repeated
};

struct RaceOptions {
  int laps = 3;
  std::uint64_t seed = 1;  // not a field: all 64 bits are valid
  double start_s = 0.0;
  double start_offset = 0.0;
  double start_yaw = 0.0;
  double mu_scale = 1.0;
  double delay_extra = 0.0;
  double compute_latency = 0.0;
  bool measure_latency = false;
  double timeout_speed = 0.3;
  double stuck_speed = 0.05;
  double stuck_time = 3.0;
  double wrong_way_distance = 3.0;
  double obstacle_sight = 0.0;
  double obstacle_at = 0.0;
  double obstacle_offset = 0.0;
  double obstacle_yaw = 0.0;
  double obstacle_length = 0.20;
  double obstacle_width = 0.33;
  bool record_path = true;

  static constexpr auto fields() {
    using P = RaceOptions;
    return std::tuple{
        Field{"laps", &P::laps, "", 1.0, 1000000.0, "number of laps, including the standing-start lap"},
        Field{"start_s", &P::start_s, "m", -1e6, 1e6, "arc length of the start and finish line"},
        Field{"start_offset", &P::start_offset, "m", -10.0, 10.0, "lateral start position, left of the centerline"},
        Field{"start_yaw", &P::start_yaw, "rad", -3.2, 3.2, "start heading relative to the centerline, left"},
        Field{"mu_scale", &P::mu_scale, "", 0.05, 3.0, "scale of the car's friction"},
        Field{"delay_extra", &P::delay_extra, "s", 0.0, 0.3, "added to steering and speed delay"},
        Field{"compute_latency", &P::compute_latency, "s", 0.0, 0.3, "compute time of the driver per scan"},
        Field{"measure_latency", &P::measure_latency, "", 0.0, 1.0,
              "the driver's compute time is its thread's CPU time: races are not reproducible"},
        Field{"timeout_speed", &P::timeout_speed, "m/s", 0.0, 10.0,
              "mean speed of a lap below which the race times out"},
        Field{"stuck_speed", &P::stuck_speed, "m/s", 0.0, 1.0, "speed below which the car counts as standing still"},
        Field{"stuck_time", &P::stuck_time, "s", 0.1, 1000.0, "standing still for this long ends the race"},
        Field{"wrong_way_distance", &P::wrong_way_distance, "m", 0.1, 1000.0,
              "driving back this far from the best progress ends the race"},
        Field{"obstacle_sight", &P::obstacle_sight, "m", 0.0, 1000.0,
              "distance at which a box appears ahead of the car (0: none)"},
        Field{"obstacle_at", &P::obstacle_at, "m", 0.0, 1e6,
              "position of the box along the track from the start, including laps"},
        Field{"obstacle_offset", &P::obstacle_offset, "m", -20.0, 20.0,
              "lateral position of the box, left of the centerline"},
        Field{"obstacle_yaw", &P::obstacle_yaw, "rad", -3.2, 3.2, "yaw of the box relative to the centerline, left"},
        Field{"obstacle_length", &P::obstacle_length, "m", 0.01, 20.0, "length of the box along its heading"},
        Field{"obstacle_width", &P::obstacle_width, "m", 0.01, 20.0, "width of the box"},
        Field{"record_path", &P::record_path, "", 0.0, 1.0, "record one sample per scan"},
    };
  }
};

class Race {
 public:
  // Keeps references to track and driver, resets the driver and places base_link on the start line. Throws
  // std::invalid_argument for an invalid parameter, track or start.
  Race(const Track& track, const Car& car, Driver& driver, const RaceOptions& options = {});

  Race(const Race&) = delete;
  Race& operator=(const Race&) = delete;

  // Advances by one scan period: the car moves, is scanned meanwhile, and the driver steps at the end. Returns false
  // when the race is over. To interrupt a race, stop calling.
  bool advance();

  const RaceResult& result() const noexcept { return result_; }
  RaceResult take_result() { return std::move(result_); }  // ends the race
  bool over() const noexcept { return result_.outcome != Outcome::running; }

  double time() const noexcept { return result_.time; }                       // [s] simulated
  Pose2 pose() const noexcept { return vehicle_.pose(); }                     // base_link, true
  VehicleState state() const noexcept { return vehicle_.state(); }            // true
  VehicleState measured() const noexcept { return measured_; }                // state given to the driver last
  SensorReading reading() const noexcept { return reading_; }                 // of the car's sensors at the last scan
  double lateral_speed() const noexcept { return vehicle_.lateral_speed(); }  // [m/s] of base_link, true
  LaserScan scan() const noexcept { return lidar_.view(given_); }             // scan given to the driver last
  StepResult step_result() const noexcept { return last_; }                   // result of the driver's last step
  double s() const noexcept { return progress_.s(); }                         // [m]
  double lateral_offset() const noexcept { return progress_.lateral_offset(); }  // [m]
  double track_length() const noexcept { return progress_.length(); }            // [m]
  Driver& driver() const noexcept { return *driver_; }

 private:
  void check_start() const;
  void move(int i);
  void sweep(const Pose2& before, const Pose2& after, int i);
  void check_laps(double distance);
  void check_obstacle();
  void check_contact();
  void end_by_contact(Point2 point, bool obstacle);
  void check_rules();
  void receive();
  VehicleState state_for_driver() noexcept;
  void drive_if_free();
  void drive();
  void record();

  const Track* track_;
  Car car_;
  Driver* driver_;
  RaceOptions options_;
  Progress progress_;
  Vehicle vehicle_;
  Lidar lidar_;
  Sensors sensors_;
  std::optional<StateEstimate> estimate_;
  Rng lidar_rng_;
  LapMeter meter_;
  std::optional<Obstacle> box_;
  Obstacle* obstacle_ = nullptr;  // the box, once it has appeared
  int steps_per_scan_ = 1;
  double step_ = 0.0, period_ = 0.0;
  long scans_ = 0;
  int next_beam_ = 0;
  double best_traveled_ = 0.0, standing_since_ = 0.0;
  double clearance_bound_ = 0.0;
  Pose2 last_pose_{};
  std::vector<float> ranges_;          // of the current sweep
  std::vector<float> waiting_ranges_;  // of the scan waiting for the driver
  std::vector<float> given_;           // of the last scan given to the driver
  bool waiting_ = false;
  double busy_until_ = 0.0;  // [s] when the driver will be done with it
  long driven_scan_ = 0, waiting_scan_ = 0;
  VehicleState measured_{}, waiting_state_{};
  SensorReading reading_{};
  StepResult last_{};
  RaceResult result_{};
};

// Runs a race to its end.
RaceResult run(const Track& track, const Car& car, Driver& driver, const RaceOptions& options = {});

}  // namespace firstlap::sim
