#include "firstlap/drivers/racer_stages.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firstlap/common/geometry.hpp"
#include "firstlap/control/stopping_check.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/perception/wall_memory.hpp"
#include "firstlap/planning/passing.hpp"
#include "firstlap/planning/path_clearance.hpp"
#include "firstlap/planning/velocity_profile.hpp"

namespace firstlap {
namespace {

constexpr std::size_t min_line_points = 4;   // of a centerline or path: fewer have no curvature
constexpr std::size_t min_points_ahead = 2;  // of these ahead of the front axle

// Whether the centerline passes the car against its heading.
bool leads_back(const Centerline& line, const CenterlineParams& params) noexcept {
  if (line.points.size() < 2) return false;
  const std::size_t i = std::clamp<std::size_t>(line.nearest, 1, line.points.size() - 1);
  const double dx = line.points[i].x - line.points[i - 1].x;
  const double dy = line.points[i].y - line.points[i - 1].y;
  return dx < params.against_heading * norm(dx, dy);
}

// [1/m] Curvature of the arc that the car is driving.
double curvature_driven(const VehicleState& state, const Params& params) noexcept {
  const double tightest = tightest_curvature(params.car);
  return std::clamp(state.yaw_rate / std::max(state.speed, params.stopping_check.start_speed), -tightest, tightest);
}

// Walls and centerline for one candidate split.
void build_line(std::size_t split, const RacerMemory& memory, const Params& params, RacerWorkspace& work) noexcept {
  const Trace& step = work.step;
  const double width = width_of(memory, params.track_width);
  split_into_sides({step.points, step.sections, step.samples}, {split, width, params.centerline.spacing}, params.car,
                   params.segmentation, work.walls);
  carry_over_occluded(memory.path_walls, {work.table, work.ranges, params.car}, params.centerline.memory_time,
                      work.walls);
  trace_centerline({work.walls, memory.trail, width}, {params.car, params.track_width, params.centerline}, work.line);
}

// Value of a split relative to the best-ranked one, from its score and its centerline.
double split_value(const SplitCandidate& candidate, const Centerline& line, const Params& params,
                   const Trace& step) noexcept {
  constexpr double tiny = 1e-3;  // for scores that may be 0
  const double penalty = line.end == LineEnd::turns_back ? params.centerline.turn_back_score : 1.0;
  return penalty * std::min(line.ahead, 2.0 * params.centerline.line_enough) * std::max(candidate.score, tiny) /
         std::max(step.candidates.items[0].score, tiny) * clearance_score(line, params.car, params.centerline) *
         side_consistency(step.sections, step.samples, candidate.split, params.segmentation);
}

// Chooses the split with the longest usable centerline. Further candidates are tried only if the value of the first is
// low: its centerline is short or tight, or passes something on the other side than before.
void choose_split(const RacerMemory& memory, const Params& params, RacerWorkspace& work) noexcept {
  Trace& step = work.step;
  step.candidates = rank_splits({step.points, step.sections, step.samples}, width_of(memory, params.track_width),
                                params.segmentation);
  double best = -1.0;
  for (std::size_t i = 0; i < step.candidates.count && best < params.centerline.line_enough; ++i) {
    const SplitCandidate& candidate = step.candidates.items[i];
    build_line(candidate.split, memory, params, work);
    const double value = split_value(candidate, work.line, params, step);
    if (value <= best) continue;
    best = value;
    step.split = candidate.split;
    std::swap(step.walls, work.walls);
    std::swap(step.line, work.line);
  }
}

void label_samples(const RacerMemory& memory, const Params& params, Buffer<SectionSample>& samples) noexcept {
  label_from_history(memory.path_walls, memory.path, memory.trail, params.segmentation, samples);
}

// Finds the path point nearest to the front axle. Returns false if too little of the path is ahead.
bool find_nearest(const Params& params, Trace& step) noexcept {
  if (step.path.size() < min_line_points) return false;
  step.nearest = nearest_on_path(step.path, params.car.wheelbase, 0.0);
  return step.nearest + min_points_ahead < step.path.size();
}

// A stop before an obstacle on the path.
struct StopAhead {
  bool near = false;        // the car has to stop just ahead
  bool full_brake = false;  // planned braking would not be enough
};

// Plans a stop before any obstacle or wall on the path, and where the track becomes too narrow for the car. It uses the
// walls of this scan, or of the last valid one, moved by odometry.
StopAhead stop_for_obstacles(double speed, const RacerMemory& memory, const Params& params, Trace& step) noexcept {
  const VelocityProfileParams& p = params.velocity_profile;
  const PathClearance found = clearance_along(step.path, step.nearest, memory.last_walls, params.car, p);
  step.clearance = found.distance;
  double blocked_at = found.blocked_at;
  if (memory.line_end == LineEnd::too_narrow) blocked_at = std::min(blocked_at, step.path.back().s);
  if (!std::isfinite(blocked_at)) return {};
  const double stop_at = blocked_at - nose(params.car) - p.block_distance;
  stop_before(stop_at, p, step.path);
  const double from = step.path[step.nearest].s;
  const StoppingCheckParams& check = params.stopping_check;
  const bool full_brake = speed * speed > -2.0 * p.a_x_min * std::max(0.0, stop_at - from) + check.brake_slack;
  return {stop_at < from + check.blocked_distance, full_brake};
}

}  // namespace

bool perceive(const LaserScan& scan, const VehicleState& state, const RacerMemory& memory, const Params& params,
              RacerWorkspace& work) noexcept {
  Trace& step = work.step;
  if (!check_scan(scan).usable() || !work.table.prepare(scan)) return false;
  scan_to_points(with_usable_time(scan, memory.period.seconds()), work.table, state, params.scan, params.car,
                 step.points);
  if (step.points.size() < scan_limits::min_returns) return false;
  segment(step.points, work.table.angle_step(), width_of(memory, params.track_width), params.segmentation,
          step.sections);
  sample_sections(step.points, step.sections, params.car, params.centerline.spacing, params.segmentation, step.samples);
  label_samples(memory, params, step.samples);
  ranges_by_beam(step.points, work.table.size(), work.ranges);
  return true;
}

void find_line(const Params& params, RacerMemory& memory, RacerWorkspace& work) noexcept {
  choose_split(memory, params, work);
  if (leads_back(work.step.line, params.centerline)) {
    forget_direction(memory);
    label_samples(memory, params, work.step.samples);
    choose_split(memory, params, work);
  }
  // The first width was only assumed: with the measured one the split may be another.
  if (!memory.width && learn_width(work.step.line, params.track_width, work.widths, memory))
    choose_split(memory, params, work);
}

bool plan_path(const VehicleState& state, const RacerMemory& memory, const Params& params,
               RacerWorkspace& work) noexcept {
  Trace& step = work.step;
  if (step.line.points.size() < min_line_points || step.line.ahead < params.stopping_check.blocked_distance)
    return false;
  const TrajectoryParams& p = params.trajectory;
  smooth_between_walls(step.line.points, params.car, p, step.smoothed);
  const PathConditions conditions{curvature_driven(state, params), 0.5 * params.car.width + p.smoothing_margin};
  const bool bent = minimum_curvature_path(step.line.points, conditions, params.minimum_curvature, work.control_points,
                                           step.smoothed);
  if (!bent && p.join_distance > 0.0) {
    const double reach = std::max(p.join_distance, p.join_time * state.speed);
    if (p.join_previous)
      join_previous(memory.path, reach, step.smoothed);
    else
      join_car(reach, p.join_angle, step.smoothed);
  }
  simplify_opheim(step.smoothed, p.opheim_min, p.opheim_max, step.simplified);
  sample_path(step.simplified, p.sample, p.end_hold, work.spline, step.path);
  if (!find_nearest(params, step)) return false;
  plan_velocity(state.speed, step.nearest, params.velocity_profile, step.path);
  return true;
}

bool recall_path(const RacerMemory& memory, const Params& params, RacerWorkspace& work) noexcept {
  if (memory.time_without_path > params.centerline.hold_time || memory.path.size() < min_line_points) return false;
  work.step.path = memory.path;
  return find_nearest(params, work.step);
}

Maneuver follow_path(const VehicleState& state, double dt, const RacerMemory& memory, const Params& params,
                     RacerWorkspace& work) noexcept {
  Trace& step = work.step;
  const VelocityProfileParams& p = params.velocity_profile;
  const StopAhead ahead = stop_for_obstacles(state.speed, memory, params, step);
  step.steering = track_path({step.path, step.nearest, state, memory.measured.steering_angle}, params.stanley,
                             params.car, step.lookahead);
  const StopLimits limits{params.car, p, params.stopping_check};
  const StopDecision stop = decide_stop({step.path, step.nearest, memory.last_walls, state},
                                        step.steering.steering_angle, dt, memory.braking, limits);
  Maneuver maneuver{.speed = command_speed(step.path, step.nearest, state.speed, p),
                    .steering_angle = stop.steering_angle,
                    .braking = stop.brake};
  const bool brakes = stop.brake || ahead.full_brake;
  maneuver.blocked = brakes || ahead.near;
  if (!brakes) return maneuver;
  // Full braking would take the grip needed for cornering: in a corner, brake only as planned.
  const bool cornering = std::abs(state.speed * state.yaw_rate) > params.stopping_check.gentle_bend_share * p.a_y_max;
  const double slowest = cornering ? state.speed + p.delta_v_min : 0.0;
  maneuver.speed = std::min(maneuver.speed, slowest);
  maneuver.steering_angle = within_grip(maneuver.steering_angle, state.speed, limits);
  return maneuver;
}

}  // namespace firstlap
