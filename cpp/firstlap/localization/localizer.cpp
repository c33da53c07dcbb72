#include "firstlap/localization/localizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "firstlap/common/geometry.hpp"
#include "firstlap/localization/field_matcher.hpp"
#include "firstlap/localization/motion.hpp"

namespace firstlap::localization {
namespace {

constexpr double max_step = 0.5;  // [s] longer pauses count as this
constexpr double fastest = 30.0;  // [m/s] and [rad/s]; larger values are not plausible
constexpr std::size_t min_beams = 5;
constexpr double raster_near = 0.12, raster_far = 0.24;  // [m], and half of it in [rad]

const LocalizerParams& validated(const LocalizerParams& params) {
  validate(params);
  return params;
}

bool sane(const VehicleState& state) {
  return std::abs(state.speed) < fastest && std::abs(state.yaw_rate) < fastest;  // also false for NaN
}

// At most `count` of the items, evenly distributed.
template <class Items>
void pick(const Items& items, std::size_t count, Buffer<Beam>& out) {
  out.clear();
  const std::size_t n = items.size(), wanted = std::min(count, n);
  for (std::size_t i = 0; i < wanted; ++i) {
    const auto& item = items[i * n / wanted];
    out.push({static_cast<float>(item.x), static_cast<float>(item.y)});
  }
}

}  // namespace

Pose2 predicted(const Pose2& pose, const VehicleState& state, const MotionParams& motion, double time) noexcept {
  if (!sane(state) || !std::isfinite(time)) return pose;
  const Pose2 later = moved(pose, motion_of(state.speed, state.yaw_rate, motion.slip, time));
  return {later.x, later.y, wrap_angle(later.yaw)};
}

Localizer::Localizer(LikelihoodField field, const CarModel& car, const LocalizerParams& params, std::uint64_t seed)
    : field_(std::move(field)),
      car_(car),
      params_(validated(params)),
      maker_(params.cloud, car),
      filter_(field_, params.filter, params.motion, seed),
      beams_(static_cast<std::size_t>(params.filter.beams)),
      dense_(static_cast<std::size_t>(params.refine.points)) {}

void Localizer::start(const Pose2& pose) noexcept {
  pose_ = field_.to_field(pose);
  filter_.scatter({pose_, params_.filter.start_radius, params_.filter.start_angle});
  estimate_ = {};
  estimate_.pose = pose;
  tight_fit_ = usual_fit_ = average_fit_ = good_time_ = 0.0;
  period_ = {};
  speed_scale_ = {};
  speed_command_ = moved_ = measured_ = 0.0;
  started_ = true;
  moving_ = was_found_ = jumped_ = false;
}

void Localizer::commanded(double speed) noexcept { speed_command_ = std::abs(speed) < fastest ? speed : 0.0; }

void Localizer::displace(const Pose2& by) noexcept {
  const Motion motion{by.x, by.y, by.yaw};
  filter_.shift(motion);
  pose_ = moved(pose_, motion);
}

Estimate Localizer::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  period_.learn(dt);
  dt = std::isfinite(dt) ? std::clamp(dt, 0.0, max_step) : 0.0;
  if (!started_) return estimate_;
  VehicleState used = sane(state) ? state : VehicleState{};
  expect_speed(speed_command_, dt, car_, speed_scale_);
  learn_from_command(used.speed, dt, params_.speed_scale, speed_scale_);
  estimate_.speed_scale = measured_speed_scale(speed_scale_, params_.speed_scale);
  estimate_.command_scale = command_speed_scale(speed_scale_, params_.speed_scale);
  used.speed *= estimate_.speed_scale;
  move(used, dt);
  if (choose_beams(scan, used)) {
    locate();
    update_status(filter_.cluster(), dt);
    learn_speed_scale(dt);
    resample();
  } else {
    estimate_.fit = tight_fit_ = 0.0;  // no usable scan: odometry alone, and soon lost
    update_status({.pose = pose_, .std = estimate_.std, .std_yaw = estimate_.std_yaw, .share = 1.0}, dt);
  }
  estimate_.pose = field_.to_map(pose_);
  return estimate_;
}

// Moves particles and estimate by the mean of the last two measurements.
void Localizer::move(const VehicleState& state, double dt) noexcept {
  const VehicleState& before = moving_ ? last_ : state;
  const double speed = 0.5 * (before.speed + state.speed), rate = 0.5 * (before.yaw_rate + state.yaw_rate);
  filter_.move(speed, rate, dt);
  pose_ = moved(pose_, motion_of(speed, rate, params_.motion.slip, dt));
  moved_ += speed * dt;
  measured_ += speed / estimate_.speed_scale * dt;
  last_ = state;
  moving_ = true;
}

// Compares the forward motion on the map, since the last update, with the measured one.
void Localizer::learn_speed_scale(double dt) noexcept {
  const double information = estimate_.searching || estimate_.lost || jumped_
                                 ? 0.0
                                 : forward_information(dense_.span(), field_, pose_, params_.refine);
  // Both poses of the motion are map matches: twice the variance of one.
  learn_from_walls({missed_, 0.5 * information}, {moved_, measured_, dt}, params_.speed_scale, speed_scale_);
  moved_ = measured_ = 0.0;
}

bool Localizer::choose_beams(const LaserScan& scan, const VehicleState& state) noexcept {
  if (!maker_.make(scan, state, period_.seconds())) return false;
  pick(maker_.points(), beams_.capacity(), beams_);
  pick(maker_.cloud(), dense_.capacity(), dense_);
  return beams_.size() >= min_beams;
}

// The best fit among the particle mean, the refined mean, and the refined odometry prediction.
void Localizer::locate() noexcept {
  filter_.weigh(beams_.span(), estimate_.searching);
  const Cluster cluster = filter_.cluster();
  const Pose2 finer = refined(dense_.span(), field_, cluster.pose, params_.refine);
  const Pose2 tracked = refined(dense_.span(), field_, pose_, params_.refine);
  const auto fit = [&](const Pose2& pose) { return fit_of(dense_.span(), field_, pose, params_.lost.fit_tight); };
  const double of_mean = fit(cluster.pose), of_finer = fit(finer), of_tracked = fit(tracked);
  const bool close = norm(tracked.x - cluster.pose.x, tracked.y - cluster.pose.y) < params_.filter.cluster_radius;
  const Pose2 expected = pose_;
  pose_ = of_finer >= of_mean ? finer : cluster.pose;
  if (close && of_tracked > std::max(of_finer, of_mean)) pose_ = tracked;
  jumped_ = norm(pose_.x - expected.x, pose_.y - expected.y) > params_.lost.jump;
  missed_ = (pose_.x - expected.x) * std::cos(expected.yaw) + (pose_.y - expected.y) * std::sin(expected.yaw);
  tight_fit_ = fit(pose_);
  estimate_.fit = fit_of(dense_.span(), field_, pose_, params_.lost.fit_distance);
}

void Localizer::update_status(const Cluster& cluster, double dt) noexcept {
  const LostParams& p = params_.lost;
  estimate_.std = cluster.std;
  estimate_.std_yaw = cluster.std_yaw;
  const bool odd = estimate_.fit < p.fit_search || tight_fit_ < usual_fit_ - p.fit_drop;
  estimate_.searching = odd || cluster.std > p.std_search || cluster.share < 0.5;
  usual_fit_ += (odd ? 0.005 : 0.05) * (tight_fit_ - usual_fit_);
  const double weight = was_found_ ? 1.0 - std::exp(-dt / p.fit_time) : 1.0;
  average_fit_ += weight * ((jumped_ && was_found_ ? 0.0 : estimate_.fit) - average_fit_);
  good_time_ = estimate_.searching || jumped_ ? 0.0 : good_time_ + dt;
  if (average_fit_ < p.fit_lost || cluster.std > p.std_lost) {
    estimate_.lost = true;
  } else if (good_time_ >= (was_found_ ? p.found_again_time : p.found_time)) {
    estimate_.lost = false;
    was_found_ = true;
  }
}

void Localizer::resample() noexcept {
  const FilterParams& p = params_.filter;
  if (!estimate_.searching) {
    const std::array around{Spread{pose_, p.explorer_radius, p.explorer_angle, p.explorers}};
    filter_.resample(static_cast<std::size_t>(p.particles_min), around);
    return;
  }
  // A grid search finds in one scan what random explorers would need many scans for. Nearby in every scan, far away in
  // every fourth.
  const bool far = ++searches_ % 4 == 0;
  const double radius = far ? p.search_radius : p.explorer_radius, angle = far ? p.search_angle : p.explorer_angle;
  const double step = far ? raster_far : raster_near;
  const Pose2 found = search(beams_.span(), field_, field_.to_map(pose_), {radius, angle, step, 0.5 * step}).pose;
  const std::array fresh{Spread{field_.to_field(found), step, 0.5 * step, p.explorers},
                         Spread{pose_, p.explorer_radius, p.explorer_angle, 2.0 * p.explorers},
                         Spread{pose_, p.search_radius, p.search_angle, 3.0 * p.explorers}};
  filter_.resample(static_cast<std::size_t>(p.particles_max), fresh);
}

}  // namespace firstlap::localization
