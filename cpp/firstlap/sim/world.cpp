#include "firstlap/sim/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "firstlap/sim/car_body.hpp"
#include "firstlap/sim/contact.hpp"

namespace firstlap::sim {

World::Agent::Agent(const Track& track, const Car& car, std::uint64_t seed)
    : vehicle(car.geometry, car.vehicle),
      lidar(car.lidar, track.walls),
      sensors(car.sensors, seed),
      noise(seed, 1),
      progress(track.centerline),
      ranges(static_cast<std::size_t>(car.lidar.beams)) {}

World::World(const Track& track, const Car& car, const WorldOptions& options, std::uint64_t seed)
    : track_(&track), car_(car), options_(options), period_(1.0 / car.lidar.rate) {
  validate(options, "world");
  car_.vehicle.friction *= options.mu_scale;
  set_steps(car.vehicle.step_dt);
  for (int i = 0; i < options.cars; ++i) {
    auto agent = std::make_unique<Agent>(track, car_, seed + static_cast<std::uint64_t>(i));
    agent->start = agent->progress.pose_at(-options.gap * i);
    if (!fits(agents_.size(), agent->start))
      throw std::invalid_argument("world: car " + std::to_string(i + 1) + " starts on a wall or a car");
    agents_.push_back(std::move(agent));
    reset(agents_.size() - 1);
  }
}

void World::set_steps(double longest) {
  steps_per_scan_ = static_cast<int>(std::ceil(period_ / longest - 1e-9));
  step_ = period_ / steps_per_scan_;
}

bool World::fits(std::size_t i, const Pose2& base_link) const {
  if (touch(car_.geometry, base_link, track_->walls)) return false;
  for (std::size_t other = 0; other < agents_.size(); ++other) {
    if (other != i && bodies_touch(car_.geometry, base_link, agents_[other]->vehicle.pose())) return false;
  }
  return true;
}

void World::change(const Car& car, double mu_scale) {
  WorldOptions options = options_;
  options.mu_scale = mu_scale;
  validate(options, "world");
  validate(car.sensors, "sensors");
  validate(car.state_estimate, "state_estimate");
  if (car.lidar.beams != car_.lidar.beams || car.lidar.rate != car_.lidar.rate) {
    throw std::invalid_argument("lidar.beams and lidar.rate cannot change while the cars drive");
  }
  const Lidar lidar(car.lidar, track_->walls);
  Car changed = car;
  changed.vehicle.friction *= mu_scale;
  for (const auto& agent : agents_) {  // only the first one can throw, since all have the same model
    agent->vehicle.change(changed.geometry, changed.vehicle);
    agent->sensors.change(changed.sensors);
    if (!(changed.state_estimate == car_.state_estimate)) restart_estimate(*agent, changed);
    agent->lidar = lidar;
  }
  car_ = changed;
  options_ = options;
  set_steps(car_.vehicle.step_dt);
}

void World::reset(std::size_t i) { place(i, agents_[i]->start); }

void World::place(std::size_t i, const Pose2& base_link) {
  Agent& agent = *agents_[i];
  agent.vehicle.reset(base_link);
  agent.progress.reset({base_link.x, base_link.y});
  agent.meter = {};
  agent.laps.clear();
  agent.contacts = 0;
  agent.crashed = agent.commanded = agent.started = false;
  agent.silent = 0.0;
  agent.last_command = {};
  restart_estimate(agent, car_);
  agent.clearance = std::numeric_limits<double>::infinity();
  agent.sensors.record(time(), sensed(agent.vehicle, car_));
}

void World::kick(std::size_t i, double lateral_speed, double yaw_rate) noexcept {
  agents_[i]->vehicle.kick(lateral_speed, yaw_rate);
}

void World::command(std::size_t i, const DriveCommand& command, double after) noexcept {
  Agent& agent = *agents_[i];
  if (agent.crashed || !std::isfinite(command.speed) || !std::isfinite(command.steering_angle)) return;
  agent.vehicle.command(command, std::clamp(after, 0.0, period_));
  agent.last_command = command;
  agent.silent = 0.0;
  agent.commanded = true;
  agent.started = agent.started || command.speed != 0.0;
}

void World::advance() {
  for (const auto& agent : agents_) {
    agent->next_beam = 0;
    agent->lidar.begin_scan(agent->noise, agent->ranges);
    agent->silent += period_;
    if (agent->commanded && options_.command_timeout > 0.0 && agent->silent > options_.command_timeout) {
      agent->last_command.speed = 0.0;
      agent->vehicle.command(agent->last_command);
      agent->commanded = false;
    }
  }
  for (int i = 1; i <= steps_per_scan_; ++i) {
    for (const auto& agent : agents_) move(*agent, i);
    for (std::size_t index = 0; index < agents_.size(); ++index) {
      sweep(index, i);
      check_contact(index);
    }
  }
  ++scans_;
  for (const auto& agent : agents_) {
    agent->lidar.add_noise(agent->ranges, agent->noise);
    measure(*agent);
  }
}

void World::restart_estimate(Agent& agent, const Car& car) {
  agent.estimate.reset();
  if (car.state_estimate.enabled) agent.estimate.emplace(car.state_estimate, model_of(car));
}

void World::measure(Agent& agent) const noexcept {
  agent.reading = agent.sensors.read(time());
  agent.measured = as_measured(agent.reading);
  if (!agent.estimate) return;
  agent.estimate->update(agent.reading, agent.last_command, period_);
  agent.measured = agent.estimate->estimate().state;
}

void World::move(Agent& agent, int i) {
  agent.before = agent.vehicle.pose();
  if (!agent.crashed) agent.vehicle.step(step_);
  const Pose2 after = agent.vehicle.pose();
  agent.sensors.record(time() + i * step_, sensed(agent.vehicle, car_));
  check_laps(agent, std::hypot(after.x - agent.before.x, after.y - agent.before.y));
}

// As in Race: casts the beams that fall into step `i`, from the pose in the middle of their time.
void World::sweep(std::size_t index, int i) {
  Agent& agent = *agents_[index];
  const double duration = car_.lidar.sweep_time, begin = period_ - duration;
  const int beams = agent.lidar.params().beams;
  const double share = duration > 0.0 ? (i * step_ - begin) / duration : -1.0;
  const int due = static_cast<int>(std::floor(share * (beams - 1))) + 1;
  const int last = i == steps_per_scan_ ? beams : std::clamp(due, 0, beams);
  if (last <= agent.next_beam) return;
  const double middle = begin + duration * 0.5 * (agent.next_beam + last - 1) / (beams - 1);
  const double t = duration > 0.0 ? std::clamp(middle / step_ - (i - 1), 0.0, 1.0) : 1.0;
  const Pose2 laser = laser_pose(car_, between(agent.before, agent.vehicle.pose(), t));
  agent.lidar.scan_sector(laser, agent.next_beam, last, agent.ranges);
  for (std::size_t other = 0; other < agents_.size(); ++other) {
    if (other == index) continue;
    const auto edges = body_edges(car_.geometry, between(agents_[other]->before, agents_[other]->vehicle.pose(), t));
    draw_body(agent.lidar.params(), laser, edges, {agent.next_beam, last}, agent.ranges);
  }
  agent.next_beam = last;
}

void World::check_laps(Agent& agent, double distance) {
  const double before = agent.progress.traveled();
  const Pose2 pose = agent.vehicle.pose();
  agent.progress.update({pose.x, pose.y});
  const double after = agent.progress.traveled(), offset = agent.progress.lateral_offset();
  const double speed = agent.vehicle.state().speed;
  const double line = agent.progress.length() * static_cast<double>(agent.laps.size() + 1);
  const double share = after >= line ? (line - before) / (after - before) : 1.0;
  if (!agent.started) return;  // the first lap starts with the first command to move
  agent.meter.add(share * step_, share * distance, speed, offset);
  if (after < line) return;
  agent.laps.push_back(agent.meter.finish(agent.laps.empty()));
  agent.meter.add((1.0 - share) * step_, (1.0 - share) * distance, speed, offset);
}

void World::check_contact(std::size_t index) {
  Agent& agent = *agents_[index];
  if (agent.crashed) return;
  const Pose2 pose = agent.vehicle.pose();
  const double clearance = sim::clearance(car_.geometry, pose, track_->walls);
  agent.clearance = std::min(agent.clearance, clearance);
  agent.meter.add_clearance(clearance);
  bool hit = clearance <= 0.0;
  for (std::size_t other = 0; other < agents_.size(); ++other) {
    hit = hit || (other != index && bodies_touch(car_.geometry, pose, agents_[other]->vehicle.pose()));
  }
  if (!hit) return;
  ++agent.contacts;
  if (!options_.contacts) return;
  agent.vehicle.reset(pose);
  agent.crashed = true;
}

}  // namespace firstlap::sim
