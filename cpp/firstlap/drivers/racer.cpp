#include "firstlap/drivers/racer.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/geometry.hpp"
#include "firstlap/common/plausible.hpp"
#include "firstlap/control/stopping_check.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/wall_memory.hpp"
#include "firstlap/planning/passing.hpp"
#include "firstlap/planning/velocity_profile.hpp"

namespace firstlap {
namespace {

// True where the line passes the car against its heading.
bool leads_back(const Centerline& line) noexcept {
  constexpr double clearly = -0.3;  // cosine of the angle
  if (line.points.size() < 2) return false;
  const std::size_t i = std::clamp<std::size_t>(line.nearest, 1, line.points.size() - 1);
  const double dx = line.points[i].x - line.points[i - 1].x;
  const double dy = line.points[i].y - line.points[i - 1].y;
  return dx < clearly * norm(dx, dy);
}

// [1/m] of the arc that the car drives; standing, it has none.
double curvature_driven(const VehicleState& state) noexcept {
  constexpr double slowest = 0.5;  // [m/s]
  constexpr double tightest = 1.5;
  return std::clamp(state.yaw_rate / std::max(state.speed, slowest), -tightest, tightest);
}

// Smallest distance of (x, y) to either wall.
double wall_distance(const LocalWalls& walls, double x, double y) noexcept {
  const double left = nearest_sample(walls.left, x, y).distance;
  const double right = nearest_sample(walls.right, x, y).distance;
  return std::min(left, right);
}

void forget(LocalWalls& walls) noexcept {
  walls.left.clear();
  walls.right.clear();
}

}  // namespace

Racer::Racer(const Params& params)
    : params_(params),
      ranges_(max_points),
      spline_(max_line_points),
      widths_(max_line_points),
      control_points_(max_control_points) {
  validate(params);
  reset();
}

void Racer::set_params(const Params& params) {
  validate(params);
  params_ = params;
}

void Racer::reset() noexcept {
  forget(memory_.walls);
  forget(memory_.seen);
  memory_.path.clear();
  memory_.trail.clear();
  memory_.width = params_.track_width.width_initial;
  memory_.width_known = false;
  memory_.line_end = LineEnd::none;
  memory_.without_path = longest_pause;
  memory_.trail_step = 0.0;
  memory_.period = {};
  memory_.moved = memory_.measured = 0.0;
  memory_.state = memory_.measured_state = {};
  memory_.speed_scale = {};
  memory_.speed_command = memory_.steering_command = 0.0;
  memory_.awake = false;
  memory_.braking = false;
}

StepResult Racer::step(const LaserScan& scan, const VehicleState& measured, double dt) noexcept {
  trace_.path.clear();
  trace_.line.points.clear();
  if (!plausible(measured, dt)) return trace_.result = stop_blind(dt);
  if (!memory_.awake || dt > longest_pause) reset();
  const VehicleState state = move_memory(measured, dt);
  memory_.period.learn(dt);
  if (!perceive(scan, state)) return trace_.result = hold_or_stop(state, dt, Status::bad_scan);
  learn_speed_scale(dt);
  choose_line();
  if (leads_back(trace_.line)) {
    forget_direction();
    choose_line();
  }
  if (!memory_.width_known && learn_width()) choose_line();
  remember_seen();
  if (!plan(state)) return trace_.result = hold_or_stop(state, dt, Status::no_path);
  return trace_.result = follow(state, dt, Status::ok);
}

// Dead reckoning: what is remembered is expressed in today's base_link. The state that this takes for true.
VehicleState Racer::move_memory(const VehicleState& measured, double dt) noexcept {
  memory_.measured_state = measured;
  VehicleState state = measured;
  learn_from_command(memory_.speed_command, measured.speed, dt, params_.speed_scale, memory_.speed_scale);
  const double scale = true_per_measured(memory_.speed_scale, params_.speed_scale);
  state.speed *= scale;
  trace_.speed_scale = scale;
  const double yaw_rate = 0.5 * (state.yaw_rate + (memory_.awake ? memory_.state.yaw_rate : state.yaw_rate));
  const double speed = 0.5 * (state.speed + (memory_.awake ? memory_.state.speed : state.speed));
  const double turn = yaw_rate * dt;
  const Pose2 motion{speed * dt * std::cos(0.5 * turn), speed * dt * std::sin(0.5 * turn), turn};
  move_walls(motion, dt, memory_.walls);
  move_walls(motion, dt, memory_.seen);

  const double c = std::cos(turn);
  const double s = std::sin(turn);
  const auto move = [&](auto& p) {
    const double dx = p.x - motion.x;
    const double dy = p.y - motion.y;
    p.x = c * dx + s * dy;
    p.y = -s * dx + c * dy;
    p.yaw -= turn;
  };
  for (TrajectoryPoint& p : memory_.path) move(p);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < memory_.trail.size(); ++i) {
    TrailPoint p = memory_.trail[i];
    move(p);
    p.age += dt;
    if (p.age < params_.centerline.trail_time) memory_.trail[kept++] = p;
  }
  memory_.trail.shrink(kept);
  memory_.trail_step += std::abs(speed) * dt;
  if (memory_.trail_step > 0.2 || memory_.trail.empty()) {
    memory_.trail.push({0.0, 0.0, 0.0, 0.0});
    memory_.trail_step = 0.0;
  }
  memory_.without_path += dt;
  memory_.moved += speed * dt;
  memory_.measured += speed / scale * dt;
  return state;
}

// By how the walls of this scan lie to those of the last good one.
void Racer::learn_speed_scale(double dt) noexcept {
  if (params_.speed_scale.scale_limit <= 0.0) return;
  const MotionError error = forward_error(memory_.seen, trace_.samples, memory_.moved, params_.speed_scale);
  learn_from_walls(error, memory_.moved, memory_.measured, dt, params_.speed_scale, memory_.speed_scale);
}

bool Racer::perceive(const LaserScan& scan, const VehicleState& state) noexcept {
  trace_.points.clear();
  trace_.sections.clear();
  trace_.samples.clear();
  if (!judge(scan).usable() || !table_.prepare(scan)) return false;
  scan_to_points(with_usable_time(scan, memory_.period.seconds()), table_, state, params_.scan, params_.car,
                 trace_.points);
  if (trace_.points.size() < scan_limits::fewest_returns) return false;
  segment(trace_.points, table_.angle_step(), memory_.width, params_.segmentation, trace_.sections);
  sample_sections(trace_.points, trace_.sections, params_.car, params_.centerline.spacing, trace_.samples);
  label_from_history(memory_.walls, memory_.path, memory_.trail, params_.segmentation, trace_.samples);
  ranges_by_beam(trace_.points, table_.size(), ranges_);
  return true;
}

void Racer::build_line(std::size_t split, LocalWalls& walls, Centerline& line) noexcept {
  const SegmentationParams& p = params_.segmentation;
  split_into_sides(trace_.points, trace_.sections, trace_.samples, split, params_.car, params_.centerline.spacing,
                   passable_gap(memory_.width, p), p.chain_gap, walls);
  carry_over_occluded(memory_.walls, table_, ranges_, params_.car, params_.centerline.memory_time, walls);
  trace_centerline(walls, memory_.trail, memory_.width, params_.car, params_.track_width, params_.centerline, line);
}

// The car was turned round: what it knows of the walls' sides is of the other direction.
void Racer::forget_direction() noexcept {
  forget(memory_.walls);
  memory_.path.clear();
  memory_.trail.clear();
  label_from_history(memory_.walls, memory_.path, memory_.trail, params_.segmentation, trace_.samples);
}

// The best split is the one whose line is usable for longest; the others are tried only where the first
// one's line is short or tight, or passes something on the other side than before.
void Racer::choose_line() noexcept {
  constexpr double enough = 2.5;  // [m] of line that leaves no doubt
  trace_.candidates =
      rank_splits(trace_.points, trace_.sections, trace_.samples, memory_.width, params_.car, params_.segmentation);
  double best = -1.0;
  for (std::size_t i = 0; i < trace_.candidates.count && best < enough; ++i) {
    const SplitCandidate& candidate = trace_.candidates.items[i];
    build_line(candidate.split, other_walls_, other_line_);
    const double penalty = other_line_.end == LineEnd::turns_back ? 0.3 : 1.0;
    const double value = penalty * std::min(other_line_.ahead, 5.0) * std::max(candidate.score, 1e-3) /
                         std::max(trace_.candidates.items[0].score, 1e-3) * clearance_score(other_line_, params_.car) *
                         side_consistency(trace_.sections, trace_.samples, candidate.split);
    if (value <= best) continue;
    best = value;
    trace_.split = candidate.split;
    std::swap(trace_.walls, other_walls_);
    std::swap(trace_.line, other_line_);
  }
}

// What the brakes work on, whether a path is found or not.
void Racer::remember_seen() noexcept {
  if (trace_.candidates.count == 0) return;
  memory_.seen = trace_.walls;
  memory_.moved = memory_.measured = 0.0;
}

bool Racer::plan(const VehicleState& state) noexcept {
  constexpr std::size_t fewest = 4;
  if (trace_.line.points.size() < fewest || trace_.line.ahead < 0.3) return false;
  const TrajectoryParams& p = params_.trajectory;
  smooth_between_walls(trace_.line.points, params_.car, p, trace_.smoothed);
  const PathConditions conditions{curvature_driven(state), 0.5 * params_.car.width + p.smoothing_margin,
                                  params_.centerline.spacing};
  const bool bent = minimum_curvature_path(trace_.line.points, conditions, params_.minimum_curvature, control_points_,
                                           trace_.smoothed);
  if (!bent && p.join_distance > 0.0) join_car(std::max(p.join_distance, p.join_time * state.speed), trace_.smoothed);
  simplify_opheim(trace_.smoothed, p.opheim_min, p.opheim_max, trace_.simplified);
  sample_path(trace_.simplified, p.sample, p.end_hold, spline_, trace_.path);
  if (trace_.path.size() < fewest) return false;
  trace_.nearest = nearest_on_path(trace_.path, params_.car.wheelbase, 0.0);
  if (trace_.nearest + 2 >= trace_.path.size()) return false;
  plan_velocity(state.speed, trace_.nearest, params_.velocity_profile, trace_.path);
  learn_width();
  trace_.width = memory_.width;
  memory_.walls = trace_.walls;
  memory_.path.assign(trace_.path.span());
  memory_.line_end = trace_.line.end;
  memory_.without_path = 0.0;
  return true;
}

// The first median is taken as it is, later ones bit by bit. A track that is too wide at most points is as wide
// as it can be: the line must not leap where it narrows to a width that counts. True where this scan told the width.
bool Racer::learn_width() noexcept {
  widths_.clear();
  std::size_t wide = 0;
  for (const CenterlinePoint& c : trace_.line.points) {
    wide += c.wide ? 1 : 0;
    if (c.support == Support::both && c.width >= params_.track_width.width_min) widths_.push(c.width);
  }
  if (wide > widths_.size()) widths_.fill(wide, params_.track_width.width_max);
  const double gain = memory_.width_known ? params_.track_width.width_gain : 1.0;
  const double before = memory_.width;
  memory_.width = remember_width(before, {widths_.data(), widths_.size()}, gain, params_.track_width);
  memory_.width_known = memory_.width_known || memory_.width != before;
  return memory_.width != before;
}

// Looks along the path for anything that the car would hit, wall or not, and plans a stop before it, also
// where the track becomes too narrow for the car. What this scan saw, or the last good one, moved.
Racer::StopAhead Racer::brake_for_obstacles(double speed) noexcept {
  const VelocityProfileParams& p = params_.velocity_profile;
  const CarGeometry& car = params_.car;
  const double nose = Footprint(car).front - car.wheelbase;  // ahead of the front axle
  const double from = trace_.path[trace_.nearest].s;
  double blocked_at = memory_.line_end == LineEnd::narrow ? trace_.path.back().s : 1e9;
  trace_.clearance = 1e9;
  for (std::size_t i = trace_.nearest; i < trace_.path.size() && trace_.path[i].s < blocked_at; i += 2) {
    const TrajectoryPoint& point = trace_.path[i];
    const double d = wall_distance(memory_.seen, point.x, point.y) - 0.5 * car.width;
    trace_.clearance = std::min(trace_.clearance, d);
    if (d < p.block_clearance && point.s > from + nose) blocked_at = point.s;
  }
  if (blocked_at > 1e8) return {};
  const double stop_at = blocked_at - nose - p.block_distance;
  stop_before(stop_at, p, trace_.path);
  const bool full_brake = speed * speed > -2.0 * p.a_x_min * std::max(0.0, stop_at - from) + 0.3;
  return {stop_at < from + 0.3, full_brake};
}

StepResult Racer::follow(const VehicleState& state, double dt, Status status) noexcept {
  const StopAhead stop = brake_for_obstacles(state.speed);
  trace_.steering = track_path(trace_.path, trace_.nearest, state, memory_.state.steering_angle, params_.stanley,
                               params_.car, trace_.lookahead);
  const double planned = command_speed(trace_.path, trace_.nearest, state.speed, params_.velocity_profile);
  double wheels = trace_.steering.steering_angle;
  const bool brakes = !can_still_stop(state, dt, wheels) || stop.full_brake;
  // Full braking takes the grip that a bend needs: there, the planned braking at most.
  const bool bends = std::abs(state.speed * state.yaw_rate) > 1.2 * params_.velocity_profile.a_y_max;
  const double least = bends ? state.speed + params_.velocity_profile.delta_v_min : 0.0;
  const double speed = brakes ? std::min(planned, least) : planned;
  if (brakes) wheels = within_grip(wheels, state.speed, params_.car, params_.velocity_profile);
  const Status said = (brakes || stop.near) && status == Status::ok ? Status::blocked : status;
  return {commanded(state, speed, wheels, dt), said};
}

// The command, within its limits and with the scale that the car makes of it; the state is that of the last step then.
DriveCommand Racer::commanded(const VehicleState& state, double speed, double wheels, double dt) noexcept {
  memory_.state = state;
  memory_.awake = true;
  trace_.command_scale = true_per_commanded(memory_.speed_scale, params_.speed_scale);
  memory_.speed_command = std::clamp(speed / trace_.command_scale, 0.0, params_.velocity_profile.v_max);
  return {memory_.speed_command, limited_steering(wheels, dt)};
}

// Whether the car could stop without touching anything if it began a scan later; if not, `wheels` becomes the angle
// with which braking now gets furthest. Once it brakes it goes on until there is some room again.
bool Racer::can_still_stop(const VehicleState& state, double dt, double& wheels) noexcept {
  constexpr double reaction = 0.05;  // [s] from command to wheels and brakes
  VelocityProfileParams params = params_.velocity_profile;
  if (memory_.braking) params.a_brake *= 0.8;
  const auto stop = [&](StopSteering how, double delay) {
    return check_stopping(trace_.path, trace_.nearest, memory_.seen, state, wheels, delay, how, params_.car, params);
  };
  memory_.braking = !stop(StopSteering::to_path, dt + reaction).clear;
  if (!memory_.braking) return true;
  StoppingCheck best = stop(StopSteering::to_path, reaction);
  for (const StopSteering how : {StopSteering::kept, StopSteering::straight}) {
    if (best.clear) break;
    const StoppingCheck other = stop(how, reaction);
    if (other.clear || other.distance > best.distance) best = other;
  }
  wheels = best.wheels;
  return false;
}

// Without a path of its own this step follows the last one for a short while.
StepResult Racer::hold_or_stop(const VehicleState& state, double dt, Status why) noexcept {
  if (memory_.without_path > params_.centerline.hold_time || memory_.path.size() < 4) return stop(state, dt, why);
  trace_.path.assign(memory_.path.span());
  trace_.nearest = nearest_on_path(trace_.path, params_.car.wheelbase, 0.0);
  if (trace_.nearest + 2 >= trace_.path.size()) return stop(state, dt, why);
  return follow(state, dt, Status::holding);
}

StepResult Racer::stop(const VehicleState& state, double dt, Status why) noexcept {
  trace_.steering = {};
  return {commanded(state, 0.0, memory_.steering_command, dt), why};
}

// What was measured means nothing: what is remembered goes on as it last moved.
StepResult Racer::stop_blind(double dt) noexcept {
  const bool timed = std::isfinite(dt) && dt >= 0.0 && dt <= longest_pause;
  if (!timed) reset();
  if (memory_.awake && timed) move_memory(memory_.measured_state, dt);
  return stop(memory_.state, 0.0, Status::bad_state);
}

double Racer::limited_steering(double wanted, double dt) noexcept {
  const CarGeometry& car = params_.car;
  const double step = car.steering_rate * dt;
  const double before = memory_.steering_command;
  const double angle =
      std::clamp(std::clamp(wanted, before - step, before + step), -car.steering_limit, car.steering_limit);
  memory_.steering_command = angle;
  return angle;
}

}  // namespace firstlap
