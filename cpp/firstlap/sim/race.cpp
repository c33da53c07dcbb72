#include "firstlap/sim/race.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "firstlap/sim/contact.hpp"
#include "firstlap/sim/cpu_clock.hpp"

namespace firstlap::sim {
namespace {

// The car with the changes from the options.
Car adapted(Car car, const RaceOptions& options) {
  validate(options, "race");
  car.vehicle.friction *= options.mu_scale;
  car.vehicle.steering_delay += options.delay_extra;
  car.vehicle.speed_delay += options.delay_extra;
  return car;
}

Pose2 start_pose(const Progress& progress, const RaceOptions& options) {
  const Pose2 line = progress.pose_at(options.start_s);
  return {line.x - options.start_offset * std::sin(line.yaw), line.y + options.start_offset * std::cos(line.yaw),
          line.yaw + options.start_yaw};
}

// Whether a wall lies between the line and the start, so that the car would start beside the track.
bool beyond_wall(const Progress& progress, const RaceOptions& options, const Walls& walls) {
  const Pose2 line = progress.pose_at(options.start_s);
  const double turn = options.start_offset > 0.0 ? 0.5 : -0.5;
  const CarGeometry gap{.width = 0.0, .length = std::abs(options.start_offset), .rear_overhang = 0.0};
  return touch(gap, {line.x, line.y, line.yaw + turn * std::numbers::pi}, walls).has_value();
}

Pose2 obstacle_pose(const Progress& progress, const RaceOptions& options) {
  const Pose2 line = progress.pose_at(options.start_s + options.obstacle_at);
  return {line.x - options.obstacle_offset * std::sin(line.yaw), line.y + options.obstacle_offset * std::cos(line.yaw),
          line.yaw + options.obstacle_yaw};
}

}  // namespace

Race::Race(const Track& track, const Car& car, Driver& driver, const RaceOptions& options)
    : track_(&track),
      car_(adapted(car, options)),
      driver_(&driver),
      options_(options),
      progress_(track.centerline),
      vehicle_(car_.geometry, car_.vehicle),
      lidar_(car_.lidar, track.walls),
      sensors_(car_.sensors, options.seed),
      lidar_rng_(options.seed, 1),
      period_(1.0 / car_.lidar.rate),
      ranges_(static_cast<std::size_t>(car_.lidar.beams)),
      waiting_ranges_(ranges_.size()),
      given_(ranges_.size()) {
  steps_per_scan_ = static_cast<int>(std::ceil(period_ / car_.vehicle.step_dt - 1e-9));
  step_ = period_ / steps_per_scan_;
  vehicle_.reset(start_pose(progress_, options_));
  last_pose_ = vehicle_.pose();
  check_start();
  progress_.reset({last_pose_.x, last_pose_.y});
  sensors_.record(0.0, sensed(vehicle_, car_));
  if (car_.state_estimate.enabled) estimate_.emplace(car_.state_estimate, model_of(car));
  if (options_.obstacle_sight > 0.0) {
    box_.emplace(obstacle_pose(progress_, options_), options_.obstacle_length, options_.obstacle_width, car_.lidar);
  }
  driver_->reset();
}

void Race::check_start() const {
  if (touch(car_.geometry, last_pose_, track_->walls)) throw std::invalid_argument("race: the car starts on a wall");
  if (beyond_wall(progress_, options_, track_->walls)) {
    throw std::invalid_argument("race: the car starts beyond a wall, " + plain(options_.start_offset) +
                                " m left of the centerline");
  }
}

bool Race::advance() {
  if (over()) return false;
  next_beam_ = 0;
  lidar_.begin_scan(lidar_rng_, ranges_);
  for (int i = 1; i <= steps_per_scan_ && !over(); ++i) move(i);
  if (over()) return false;
  ++scans_;
  lidar_.add_noise(ranges_, lidar_rng_);
  receive();
  if (options_.record_path) record();
  check_rules();
  return !over();
}

// Physics step `i` (from 1) of this scan period.
void Race::move(int i) {
  const Pose2 before = vehicle_.pose();
  vehicle_.step(step_);
  const Pose2 after = vehicle_.pose();
  result_.time = static_cast<double>(scans_) * period_ + i * step_;
  sensors_.record(result_.time, sensed(vehicle_, car_));
  sweep(before, after, i);
  check_laps(std::hypot(after.x - before.x, after.y - before.y));
  if (!over()) check_obstacle();
  if (!over()) check_contact();
  if (!over()) drive_if_free();
}

// Casts the beams that fall into step `i`, from the pose in the middle of their time. The last beam is measured at the
// scan time, the first one sweep_time earlier.
void Race::sweep(const Pose2& before, const Pose2& after, int i) {
  const double duration = car_.lidar.sweep_time, begin = period_ - duration;
  const auto beam_at = [&](double time) {
    return duration > 0.0 ? (time - begin) / duration * (lidar_.params().beams - 1) : -1.0;
  };
  const int beams = lidar_.params().beams;
  const int due = static_cast<int>(std::floor(beam_at(i * step_))) + 1;
  const int last = i == steps_per_scan_ ? beams : std::clamp(due, 0, beams);
  if (last <= next_beam_) return;
  const double middle = begin + duration * 0.5 * (next_beam_ + last - 1) / (beams - 1);
  const double t = duration > 0.0 ? std::clamp(middle / step_ - (i - 1), 0.0, 1.0) : 1.0;
  const Pose2 laser = laser_pose(car_, between(before, after, t));
  lidar_.scan_sector(laser, next_beam_, last, ranges_);
  if (obstacle_) obstacle_->add_to_scan(laser, next_beam_, last, ranges_);
  next_beam_ = last;
}

// Splits the step between the laps that it belongs to, interpolating the crossing of the line.
void Race::check_laps(double distance) {
  const double before = progress_.traveled();
  const Pose2 pose = vehicle_.pose();
  progress_.update({pose.x, pose.y});
  const double after = progress_.traveled(), speed = vehicle_.state().speed, offset = progress_.lateral_offset();
  const double line = progress_.length() * static_cast<double>(result_.laps.size() + 1);
  const double share = after >= line ? (line - before) / (after - before) : 1.0;
  result_.distance += share * distance;
  meter_.add(share * step_, share * distance, speed, offset);
  if (after < line) return;
  result_.laps.push_back(meter_.finish(result_.laps.empty()));
  if (static_cast<int>(result_.laps.size()) == options_.laps) {
    result_.outcome = Outcome::finished;
    result_.time -= (1.0 - share) * step_;
    return;
  }
  result_.distance += (1.0 - share) * distance;
  meter_.add((1.0 - share) * step_, (1.0 - share) * distance, speed, offset);
}

// The box appears once and stays for the rest of the race. It must also be near along the track: in a hairpin it may be
// close, but far ahead.
void Race::check_obstacle() {
  if (!box_) return;
  Obstacle& box = *box_;
  const Pose2 pose = vehicle_.pose();
  if (!obstacle_) {
    const double ahead = options_.obstacle_at - progress_.traveled();
    if (ahead > 2.0 * options_.obstacle_sight + reach(car_.geometry) + options_.obstacle_length) return;
    if (clearance(car_.geometry, pose, box.walls()) > options_.obstacle_sight) return;
    obstacle_ = &box;
    const VehicleState state = vehicle_.state();
    result_.obstacle = ObstacleSeen{result_.time, box.middle(), state.speed, state.yaw_rate, 1e9};
  }
  const double distance = box.clearance(car_.geometry, pose);
  if (result_.obstacle) {
    ObstacleSeen& seen = *result_.obstacle;
    seen.clearance = std::min(seen.clearance, distance);
  }
  meter_.add_clearance(distance);
  if (distance > 0.0) return;
  end_by_contact(box.touch(car_.geometry, pose).value_or(Point2{pose.x, pose.y}), true);
}

// The exact test is needed only if the car may have come closer than ever in this lap: between tests the clearance
// shrinks by at most the displacement of the car's farthest point.
void Race::check_contact() {
  const Pose2 pose = vehicle_.pose();
  const double turn = std::abs(std::remainder(pose.yaw - last_pose_.yaw, 2.0 * std::numbers::pi));
  clearance_bound_ -= std::hypot(pose.x - last_pose_.x, pose.y - last_pose_.y) + reach(car_.geometry) * turn;
  last_pose_ = pose;
  if (clearance_bound_ > meter_.min_clearance()) return;
  clearance_bound_ = clearance(car_.geometry, pose, track_->walls);
  meter_.add_clearance(clearance_bound_);
  if (clearance_bound_ > 0.0) return;
  end_by_contact(touch(car_.geometry, pose, track_->walls).value_or(Point2{pose.x, pose.y}), false);
}

void Race::end_by_contact(Point2 point, bool obstacle) {
  result_.contact = Contact{result_.time, point.x, point.y, progress_.s(), obstacle};
  result_.outcome = Outcome::contact;
}

// A new scan replaces a waiting one, which is skipped.
void Race::receive() {
  if (waiting_) ++result_.skipped_scans;
  waiting_ranges_ = ranges_;
  waiting_state_ = state_for_driver();
  waiting_scan_ = scans_;
  waiting_ = true;
  drive_if_free();
}

VehicleState Race::state_for_driver() noexcept {
  reading_ = sensors_.read(result_.time);
  if (!estimate_) return as_measured(reading_);
  estimate_->update(reading_, last_.command, period_);
  return estimate_->estimate().state;
}

void Race::drive_if_free() {
  if (waiting_ && result_.time + 1e-9 >= busy_until_) drive();
}

void Race::drive() {
  std::swap(given_, waiting_ranges_);
  measured_ = waiting_state_;
  waiting_ = false;
  const LaserScan scan = lidar_.view(given_);
  const double dt = period_ * static_cast<double>(waiting_scan_ - std::exchange(driven_scan_, waiting_scan_));
  const double begin = cpu_seconds();
  last_ = driver_->step(scan, measured_, dt);
  const double spent = cpu_seconds() - begin;
  result_.compute_times.push_back(static_cast<float>(1e6 * spent));

  // Physics advances in steps; the driver started as soon as it was idle and had a scan.
  const double scanned = static_cast<double>(waiting_scan_) * period_;
  const double begun = std::min(std::max(busy_until_, scanned), result_.time);
  busy_until_ = begun + (options_.measure_latency ? spent : options_.compute_latency);
  vehicle_.command(last_.command, std::max(busy_until_ - result_.time, 0.0));
}

void Race::record() {
  const Pose2 pose = vehicle_.pose();
  const VehicleState truth = vehicle_.state();
  result_.path.push_back({.time = result_.time,
                          .x = pose.x,
                          .y = pose.y,
                          .yaw = pose.yaw,
                          .speed = truth.speed,
                          .yaw_rate = truth.yaw_rate,
                          .steering_angle = truth.steering_angle,
                          .s = progress_.s(),
                          .lateral_offset = progress_.lateral_offset(),
                          .command_speed = last_.command.speed,
                          .command_steering_angle = last_.command.steering_angle,
                          .status = last_.status});
}

void Race::check_rules() {
  best_traveled_ = std::max(best_traveled_, progress_.traveled());
  if (std::abs(vehicle_.state().speed) >= options_.stuck_speed) standing_since_ = result_.time;
  if (progress_.traveled() < best_traveled_ - options_.wrong_way_distance) {
    result_.outcome = Outcome::wrong_way;
  } else if (result_.time - standing_since_ >= options_.stuck_time) {
    result_.outcome = Outcome::stuck;
  } else if (meter_.time() * options_.timeout_speed > progress_.length()) {
    result_.outcome = Outcome::timeout;
  }
}

RaceResult run(const Track& track, const Car& car, Driver& driver, const RaceOptions& options) {
  Race race(track, car, driver, options);
  while (race.advance()) {
  }
  return race.take_result();
}

}  // namespace firstlap::sim
