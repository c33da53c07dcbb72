#include "firstlap/drivers/follow_the_gap.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/common/plausible.hpp"
#include "firstlap/drivers/driver_params.hpp"

namespace firstlap::drivers {
namespace {

// Inflation radius, reduced if the car is already closer to a return, so that free directions remain.
double shadow_radius(double wanted, const Buffer<double>& ranges) noexcept {
  double nearest = wanted;
  for (const double r : ranges) nearest = std::min(nearest, 0.9 * r);
  return nearest;
}

}  // namespace

void validate(const FollowTheGapParams& params) { validate_driver(params); }

FollowTheGap::FollowTheGap(const FollowTheGapParams& params) : params_(params) { validate(params); }

StepResult FollowTheGap::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  trace_.free.clear();
  if (!plausible(state, dt)) return stop(0.0, Status::bad_state);
  if (dt > max_pause) reset();
  period_.learn(dt);
  if (!sweep_.read(scan, state, period_, params_.scan, params_.car)) return stop(dt, Status::bad_scan);
  inflate();
  apply_bubble();
  if (!choose_run()) return stop(dt, Status::no_path);
  choose_aim();
  choose_arc(state);
  steering_ = smooth_steering(trace_.arc, steering_, dt, params_.steering.steering_time, params_.car);
  const bool blocked = trace_.arc_free <= params_.speed.stop_distance;
  const double free = blocked ? 0.0 : trace_.aim_free;
  speed_ = plan_speed(free, curvature_of(trace_.arc, params_.car), {state.speed, speed_, dt}, params_.speed);
  return trace_.result = {{speed_, steering_}, blocked ? Status::blocked : Status::ok};
}

// Free distance of the car, as a disc, in each direction.
void FollowTheGap::inflate() noexcept {
  trace_.step = params_.gap.view_angle / directions_per_side;
  trace_.ranges.assign(sweep_.ranges().span());
  trace_.first_beam = sweep_.angle(0);
  trace_.beam_step = sweep_.angle_step();
  trace_.free.fill(directions, params_.scan.range_use);
  const double radius = shadow_radius(0.5 * params_.car.width + params_.gap.body_margin, sweep_.ranges());
  // If beams are denser than directions, only the nearest return of each group of beams is used. The groups are
  // symmetric about the middle.
  const int beams = static_cast<int>(sweep_.size());
  const double group = std::min(1.7 * trace_.step / sweep_.angle_step(), static_cast<double>(beams));
  const int half = std::max(0, (static_cast<int>(group) - 1) / 2);
  const int stride = 2 * half + 1;
  const int odd = beams % 2;
  for (int i = 0; i < beams; ++i) {
    const int from_middle = std::abs(2 * i - (beams - 1)) / 2;
    if (from_middle % stride == (odd == 1 ? 0 : half)) cast_shadow(nearest_of(i - half, i + half), radius);
  }
}

std::size_t FollowTheGap::nearest_of(int first, int last) const noexcept {
  auto nearest = static_cast<std::size_t>((first + last) / 2);
  const auto end = std::min(static_cast<std::size_t>(last) + 1, sweep_.size());
  for (auto i = static_cast<std::size_t>(std::max(first, 0)); i < end; ++i)
    if (sweep_.range(i) < sweep_.range(nearest)) nearest = i;
  return nearest;
}

// Shortens every direction in which a disc of `radius` would touch the return of this beam.
void FollowTheGap::cast_shadow(std::size_t beam, double radius) noexcept {
  const double r = sweep_.range(beam);
  const double angle = sweep_.angle(beam);
  const double half = std::asin(std::min(radius / r, 1.0));
  const int first = std::max(static_cast<int>(std::ceil((angle - half) / trace_.step)), -directions_per_side);
  const int last = std::min(static_cast<int>(std::floor((angle + half) / trace_.step)), directions_per_side);
  for (int k = first; k <= last; ++k) {
    const double off = angle_of(k) - angle;
    const double across = r * off * (1.0 - off * off / 6.0);  // sin and cos by their series: `half` is below 1.2 rad
    const double along = r * (1.0 - 0.5 * off * off * (1.0 - off * off / 12.0));
    const double touch = along - std::sqrt(std::max(radius * radius - across * across, 0.0));
    free_at(k) = std::min(free_at(k), std::max(touch, 0.0));
  }
}

void FollowTheGap::apply_bubble() noexcept {
  const double view = params_.gap.view_angle;
  std::size_t nearest = sweep_.beam_at(0.0);
  for (std::size_t i = 0; i < sweep_.size(); ++i)
    if (std::abs(sweep_.angle(i)) <= view && sweep_.range(i) < sweep_.range(nearest)) nearest = i;
  const double r = sweep_.range(nearest);
  const CarGeometry& car = params_.car;
  trace_.nearest = {car.laser_x + r * sweep_.cosine(nearest), car.laser_y + r * sweep_.sine(nearest)};
  const double half = std::asin(std::min(params_.gap.bubble_radius / r, 1.0));
  for (int k = -directions_per_side; k <= directions_per_side; ++k)
    if (std::abs(angle_of(k) - sweep_.angle(nearest)) < half) free_at(k) = 0.0;
}

// Lowers the threshold if no direction is free that far.
bool FollowTheGap::choose_run() noexcept {
  constexpr int attempts = 12;
  trace_.threshold = std::min(params_.gap.free_distance, params_.scan.range_use);
  for (int i = 0; i < attempts; ++i, trace_.threshold *= 0.75)
    if (best_run(trace_.threshold)) return true;
  return false;
}

bool FollowTheGap::best_run(double threshold) noexcept {
  double best = 0.0;
  double value = 0.0;
  int first = -directions_per_side;
  for (int k = -directions_per_side; k <= directions_per_side + 1; ++k) {
    if (k <= directions_per_side && free_at(k) >= threshold) {
      if (value == 0.0) first = k;
      value += std::pow(free_at(k), params_.gap.run_power);
      continue;
    }
    // Among runs of equal score the one closest to straight ahead.
    const bool nearer = std::abs(first + k - 1) < std::abs(trace_.run_first + trace_.run_last);
    if (value > best * (1.0 + 1e-9) || (value > 0.0 && value >= best * (1.0 - 1e-9) && nearer)) {
      best = value;
      trace_.run_first = first;
      trace_.run_last = k - 1;
    }
    value = 0.0;
  }
  return best > 0.0;
}

void FollowTheGap::choose_aim() noexcept {
  const int first = trace_.run_first;
  const int last = trace_.run_last;
  const int width = std::clamp(static_cast<int>(params_.gap.window_angle / trace_.step), 1, last - first + 1);
  double sum = 0.0;
  for (int k = first; k < first + width; ++k) sum += free_at(k);
  double best = sum;
  double middle = first + 0.5 * (width - 1);
  const double center = 0.5 * (first + last);
  for (int k = first + 1; k + width - 1 <= last; ++k) {
    sum += free_at(k + width - 1) - free_at(k - 1);
    const double here = k + 0.5 * (width - 1);
    const bool same = sum > best - 1e-6;
    if (sum > best + 1e-6 || (same && std::abs(here - center) < std::abs(middle - center))) {
      best = std::max(sum, best);
      middle = here;
    }
  }
  const double weight = params_.gap.center_weight;
  trace_.window = trace_.step * middle;
  trace_.aim = trace_.step * (weight * center + (1.0 - weight) * middle);
  trace_.aim_free = free_at(static_cast<int>(std::lround(trace_.aim / trace_.step)));
}

// The steering angle nearest to the wanted one whose arc is free far enough; the one with the farthest arc if there is
// none.
void FollowTheGap::choose_arc(const VehicleState& state) noexcept {
  constexpr int tries = 8;  // per side
  const GapParams& p = params_.gap;
  const CarGeometry& car = params_.car;
  trace_.wanted = within_grip(params_.steering.steering_gain * trace_.aim, state.speed, params_.steering, car);
  const double enough = std::max(p.arc_distance, p.arc_time * state.speed);
  const double margin = margin_beside(sweep_.points(), p.arc_margin, car);
  const auto free = [&](double angle) {
    return free_along_arc(sweep_.points(), curvature_of(angle, car), margin, params_.scan.range_use, car);
  };
  trace_.arc = trace_.wanted;
  trace_.arc_free = free(trace_.wanted);
  // Order of the tries by the side of the aim, so that a mirrored scan gives a mirrored result.
  const double side = trace_.aim < 0.0 ? -1.0 : 1.0;
  for (int i = 1; i <= tries && trace_.arc_free < enough; ++i) {
    for (const double sign : {-side, side}) {
      const double angle = std::clamp(trace_.wanted + sign * i * 2.0 * car.steering_limit / tries * 0.5,
                                      -car.steering_limit, car.steering_limit);
      const double here = free(angle);
      if (here <= trace_.arc_free) continue;
      trace_.arc = angle;
      trace_.arc_free = here;
    }
  }
}

StepResult FollowTheGap::stop(double dt, Status why) noexcept {
  speed_ = 0.0;
  steering_ = smooth_steering(steering_, steering_, dt, 0.0, params_.car);
  trace_.arc_free = trace_.aim_free = 0.0;
  return trace_.result = {{0.0, steering_}, why};
}

}  // namespace firstlap::drivers
