#include "firstlap/drivers/racer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firstlap/common/plausible.hpp"
#include "firstlap/control/limits.hpp"
#include "firstlap/drivers/racer_stages.hpp"

namespace firstlap {

Racer::Racer(const Params& params) : params_(params) { validate(params); }

void Racer::set_params(const Params& params) {
  validate(params);
  params_ = params;
}

// The stages work in the workspace. At the end its results are swapped with the trace: nothing is copied, and the trace
// is never read.
StepResult Racer::step(const LaserScan& scan, const VehicleState& measured, double dt) noexcept {
  work_.step.clear();
  work_.step.result = drive(scan, measured, dt);
  work_.step.width = width_of(memory_, params_.track_width);
  std::swap(trace_, work_.step);
  return trace_.result;
}

StepResult Racer::drive(const LaserScan& scan, const VehicleState& measured, double dt) noexcept {
  Trace& step = work_.step;
  // 1. Reject implausible measurements. After a long pause, forget earlier scans.
  if (!plausible(measured, dt)) return drive_blind(dt);
  if (!memory_.initialized || dt > max_pause) reset();

  // 2. Estimation: correct the measured speed, and move the memory by odometry.
  step.speed_scale = learn_from_driving(measured, dt, params_.car, params_.speed_scale, memory_);
  const VehicleState state{measured.speed * step.speed_scale, measured.yaw_rate, measured.steering_angle};
  move_by_odometry(state, step.speed_scale, dt, params_.centerline, memory_);
  memory_.period.learn(dt);

  // 3. Perception, planning and memory. Without a path from this scan, hold the last one for a short time.
  Status status = plan(scan, state, dt);
  if (status == Status::ok) {
    learn_width(step.line, params_.track_width, work_.widths, memory_);
    remember_path(step.path, step.walls, step.line.end, memory_);
  } else if (recall_path(memory_, params_, work_)) {
    status = Status::holding;
  }

  // 4. Control: follow the path, unless the stopping check decides to brake. Without a path, stop with the steering
  // angle held.
  Maneuver maneuver{.steering_angle = memory_.command.steering_angle};
  if (status == Status::ok || status == Status::holding) {
    maneuver = follow_path(state, dt, memory_, params_, work_);
    memory_.braking = maneuver.braking;
  }
  if (maneuver.blocked && status == Status::ok) status = Status::blocked;
  memory_.measured = measured;
  memory_.speed = state.speed;
  return {command({maneuver.speed, maneuver.steering_angle}, dt), status};
}

// Perception: points, sections, labeled samples. Planning: the sides and the centerline between them, then path and
// velocity profile.
Status Racer::plan(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  if (!perceive(scan, state, memory_, params_, work_)) return Status::bad_scan;
  learn_from_scan(work_.step.samples, dt, params_.speed_scale, memory_);
  find_line(params_, memory_, work_);
  if (work_.step.candidates.count > 0) remember_walls(work_.step.walls, memory_);
  return plan_path(state, memory_, params_, work_) ? Status::ok : Status::no_path;
}

// Without a plausible measurement, the memory moves with the previous one and the car stops.
StepResult Racer::drive_blind(double dt) noexcept {
  const bool timed = std::isfinite(dt) && dt >= 0.0 && dt <= max_pause;
  if (!timed) reset();
  if (memory_.initialized && timed) {
    VehicleState state = memory_.measured;
    work_.step.speed_scale = learn_from_driving(state, dt, params_.car, params_.speed_scale, memory_);
    state.speed *= work_.step.speed_scale;
    move_by_odometry(state, work_.step.speed_scale, dt, params_.centerline, memory_);
  }
  return {command({0.0, memory_.command.steering_angle}, 0.0), Status::bad_state};
}

// The command within the car's limits, `dt` [s] after the previous one, corrected by the command scale.
DriveCommand Racer::command(const DriveCommand& wanted, double dt) noexcept {
  work_.step.command_scale = command_speed_scale(memory_.speed_scale, params_.speed_scale);
  const double speed = wanted.speed / work_.step.command_scale;
  memory_.command = {std::clamp(speed, 0.0, params_.velocity_profile.v_max),
                     limit_steering(wanted.steering_angle, memory_.command.steering_angle, dt, params_.car)};
  memory_.initialized = true;
  return memory_.command;
}

}  // namespace firstlap
