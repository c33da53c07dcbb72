#include "firstlap/drivers/disparity_extender.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/plausible.hpp"
#include "firstlap/drivers/driver_params.hpp"

namespace firstlap::drivers {

void validate(const DisparityExtenderParams& params) { validate_driver(params); }

DisparityExtender::DisparityExtender(const DisparityExtenderParams& params) : params_(params) { validate(params); }

StepResult DisparityExtender::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  trace_.extended.clear();
  if (!plausible(state, dt)) return stop(0.0, Status::bad_state);
  if (dt > max_pause) reset();
  period_.learn(dt);
  if (!sweep_.read(scan, state, period_, params_.scan, params_.car)) return stop(dt, Status::bad_scan);
  extend_disparities();
  choose_block();
  const CarGeometry& car = params_.car;
  trace_.wanted = within_grip(params_.steering.steering_gain * trace_.aim, state.speed, params_.steering, car);
  const double angle = turn_with_clearance(trace_.wanted);
  steering_ = smooth_steering(angle, steering_, dt, params_.steering.steering_time, car);

  const double margin = margin_beside(sweep_.points(), params_.disparity.emergency_margin, car);
  const double ahead = free_along_arc(sweep_.points(), curvature_of(angle, car), margin, params_.scan.range_use, car);
  const bool blocked = ahead <= params_.speed.stop_distance;
  const double w = params_.disparity.straight_weight;
  const double far = (1.0 - w) * trace_.aim_free + w * std::min(trace_.aim_free, trace_.straight_free);
  speed_ = plan_speed(blocked ? 0.0 : far, curvature_of(angle, car), {state.speed, speed_, dt}, params_.speed);
  return trace_.result = {{speed_, steering_}, blocked ? Status::blocked : Status::ok};
}

void DisparityExtender::extend_disparities() noexcept {
  trace_.ranges.assign(sweep_.ranges().span());
  trace_.extended.assign(sweep_.ranges().span());
  trace_.first_beam = sweep_.angle(0);
  trace_.beam_step = sweep_.angle_step();
  trace_.disparities.clear();
  for (std::size_t i = 0; i + 1 < sweep_.size(); ++i) {
    const double jump = sweep_.range(i + 1) - sweep_.range(i);
    if (std::abs(jump) <= params_.disparity.disparity) continue;
    const std::size_t near = jump > 0.0 ? i : i + 1;
    trace_.disparities.push(static_cast<int>(near));
    extend(near, jump > 0.0 ? 1 : -1);
  }
}

// Extends the nearer beam `from` to the left (+1) or right (-1), over half the car's width plus the tolerance. Shorter
// ranges stay.
void DisparityExtender::extend(std::size_t from, int direction) noexcept {
  const double width = 0.5 * params_.car.width + params_.disparity.tolerance;
  const double r = sweep_.range(from);
  const double angle = 2.0 * std::asin(std::min(0.5 * width / r, 1.0));
  const auto beams = static_cast<long>(std::ceil(angle / sweep_.angle_step()));
  const auto last = static_cast<long>(sweep_.size()) - 1;
  for (long k = 1; k <= beams; ++k) {
    const long i = static_cast<long>(from) + direction * k;
    if (i < 0 || i > last) return;
    double& range = trace_.extended[static_cast<std::size_t>(i)];
    range = std::min(range, r);
  }
}

double DisparityExtender::middle_of(const Block& block) const noexcept {
  return 0.5 * (sweep_.angle(block.first) + sweep_.angle(block.last));
}

// The wider one, then the one closer to straight ahead.
bool DisparityExtender::is_better(const Block& block, const Block& than) const noexcept {
  const std::size_t width = block.last - block.first;
  const std::size_t before = than.last - than.first;
  return width > before || (width == before && std::abs(middle_of(block)) < std::abs(middle_of(than)));
}

// The best block of beams above a share of the farthest range.
void DisparityExtender::choose_block() noexcept {
  const std::size_t first = sweep_.beam_at(-params_.disparity.view_angle);
  const std::size_t last = sweep_.beam_at(params_.disparity.view_angle);
  double farthest = 0.0;
  for (std::size_t i = first; i <= last; ++i) farthest = std::max(farthest, trace_.extended[i]);
  const double enough = params_.disparity.block_share * farthest;
  Block best{first, first};
  bool found = false;
  for (std::size_t i = first; i <= last; ++i) {
    if (trace_.extended[i] < enough) continue;
    Block block{i, i};
    while (block.last < last && trace_.extended[block.last + 1] >= enough) ++block.last;
    if (!found || is_better(block, best)) best = block;
    found = true;
    i = block.last;
  }
  trace_.block_first = static_cast<int>(best.first);
  trace_.block_last = static_cast<int>(best.last);
  trace_.aim = middle_of(best);
  trace_.aim_free = trace_.extended[sweep_.beam_at(trace_.aim)];
  trace_.straight_free = trace_.extended[sweep_.beam_at(0.0)];
}

double DisparityExtender::turn_with_clearance(double wanted) noexcept {
  const LateralClearance beside = lateral_clearance(sweep_.points(), params_.car);
  trace_.held_left = beside.left < params_.disparity.side_clearance && wanted > 0.0;
  trace_.held_right = beside.right < params_.disparity.side_clearance && wanted < 0.0;
  return trace_.held_left || trace_.held_right ? 0.0 : wanted;
}

StepResult DisparityExtender::stop(double dt, Status why) noexcept {
  speed_ = 0.0;
  steering_ = smooth_steering(steering_, steering_, dt, 0.0, params_.car);
  return trace_.result = {{0.0, steering_}, why};
}

}  // namespace firstlap::drivers
