// Several identical cars on one track, commanded from outside, for a simulator node. Every car sees the others in its
// scans and can touch them; after a contact it stops until it is reset. The same seed and commands give the same world,
// bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "firstlap/estimation/state_estimate.hpp"
#include "firstlap/sim/car.hpp"
#include "firstlap/sim/lap_meter.hpp"
#include "firstlap/sim/progress.hpp"
#include "firstlap/sim/race.hpp"
#include "firstlap/sim/vehicle.hpp"

namespace firstlap::sim {

struct WorldOptions {
  int cars = 1;
  double gap = 3.0;
  double command_timeout = 0.2;
  double mu_scale = 1.0;
  bool contacts = true;

  static constexpr auto fields() {
    using P = WorldOptions;
    return std::tuple{
        Field{"cars", &P::cars, "", 1.0, 16.0, "number of cars on the track"},
        Field{"gap", &P::gap, "m", 0.6, 1000.0, "starting distance between cars along the centerline"},
        Field{"command_timeout", &P::command_timeout, "s", 0.0, 10.0,
              "a car without a command for this long is stopped, like a real car by its mux (0: never)"},
        Field{"mu_scale", &P::mu_scale, "", 0.05, 3.0, "scale of the car's friction"},
        Field{"contacts", &P::contacts, "", 0.0, 1.0, "a car that touches something stops until it is reset"},
    };
  }
};

class World {
 public:
  // Keeps a reference to `track`. The first car starts on the line. Throws std::invalid_argument for invalid parameters
  // or starts.
  World(const Track& track, const Car& car, const WorldOptions& options, std::uint64_t seed);

  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Gives car `i` a command `after` [s] from now, at most one scan period. Ignored if not finite.
  void command(std::size_t i, const DriveCommand& command, double after) noexcept;

  // Advances all cars by one scan period.
  void advance();

  // Places a car at its start, or at a pose, at rest. Its laps start again.
  void reset(std::size_t i);
  void place(std::size_t i, const Pose2& base_link);
  void kick(std::size_t i, double lateral_speed,
            double yaw_rate) noexcept;  // adds to lateral speed [m/s] and yaw rate [rad/s]

  // Whether car `i` can be placed there without contact with a wall or another car.
  bool fits(std::size_t i, const Pose2& base_link) const;

  // Changes the parameters of all cars from now on, with `mu_scale` times the friction; motion and laps continue.
  // Throws std::invalid_argument for invalid parameters, or a change of lidar.beams, lidar.rate or vehicle.model; then
  // nothing changes.
  void change(const Car& car, double mu_scale);

  std::size_t size() const noexcept { return agents_.size(); }
  double time() const noexcept { return static_cast<double>(scans_) * period_; }  // [s]
  double period() const noexcept { return period_; }                              // [s] between scans
  const Car& car() const noexcept { return car_; }

  Pose2 pose(std::size_t i) const noexcept { return agents_[i]->vehicle.pose(); }                     // base_link, true
  VehicleState state(std::size_t i) const noexcept { return agents_[i]->vehicle.state(); }            // true
  double lateral_speed(std::size_t i) const noexcept { return agents_[i]->vehicle.lateral_speed(); }  // [m/s]
  double forward_acceleration(std::size_t i) const noexcept { return agents_[i]->vehicle.forward_acceleration(); }
  double lateral_acceleration(std::size_t i) const noexcept { return agents_[i]->vehicle.lateral_acceleration(); }
  VehicleState measured(std::size_t i) const noexcept { return agents_[i]->measured; }  // given to the driver
  SensorReading reading(std::size_t i) const noexcept { return agents_[i]->reading; }   // of the car's sensors
  LaserScan scan(std::size_t i) const noexcept { return agents_[i]->lidar.view(agents_[i]->ranges); }
  const std::vector<Lap>& laps(std::size_t i) const noexcept { return agents_[i]->laps; }
  int contacts(std::size_t i) const noexcept { return agents_[i]->contacts; }       // since the last reset
  bool standing(std::size_t i) const noexcept { return agents_[i]->crashed; }       // stopped after a contact
  double clearance(std::size_t i) const noexcept { return agents_[i]->clearance; }  // [m] smallest since the last reset
  double lap_clearance(std::size_t i) const noexcept { return agents_[i]->meter.min_clearance(); }  // [m] in this lap
  double s(std::size_t i) const noexcept { return agents_[i]->progress.s(); }
  double lateral_offset(std::size_t i) const noexcept { return agents_[i]->progress.lateral_offset(); }

 private:
  struct Agent {
    Agent(const Track& track, const Car& car, std::uint64_t seed);
    Vehicle vehicle;
    Lidar lidar;
    Sensors sensors;
    Rng noise;
    Progress progress;
    LapMeter meter;
    Pose2 start{}, before{};
    std::vector<float> ranges;
    std::vector<Lap> laps;
    SensorReading reading{};
    VehicleState measured{};
    std::optional<StateEstimate> estimate{};
    DriveCommand last_command{};
    double silent = 0.0, clearance = 0.0;
    int next_beam = 0, contacts = 0;
    bool commanded = false, crashed = false, started = false;
  };

  void set_steps(double longest);
  void move(Agent& agent, int i);
  static void restart_estimate(Agent& agent, const Car& car);
  void measure(Agent& agent) const noexcept;
  void sweep(std::size_t index, int i);
  void check_laps(Agent& agent, double distance);
  void check_contact(std::size_t index);

  const Track* track_;
  Car car_;
  WorldOptions options_;
  std::vector<std::unique_ptr<Agent>> agents_;
  int steps_per_scan_ = 1;
  double step_ = 0.0, period_ = 0.0;
  long scans_ = 0;
};

}  // namespace firstlap::sim
