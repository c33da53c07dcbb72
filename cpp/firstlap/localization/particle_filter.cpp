#include "firstlap/localization/particle_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firstlap/common/geometry.hpp"

namespace firstlap::localization {

ParticleFilter::Table ParticleFilter::table(double sigma, const FilterParams& params) {
  Table result{};
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double ratio = 1e-3 * static_cast<double>(i) / sigma;
    const double likelihood = std::exp(-0.5 * ratio * ratio) + params.noise_floor;
    result[i] = static_cast<float>(params.weight_power * std::log(likelihood));
  }
  return result;
}

ParticleFilter::ParticleFilter(const LikelihoodField& field, const FilterParams& filter, const MotionParams& motion,
                               std::uint64_t seed)
    : field_(&field),
      params_(filter),
      motion_(motion),
      rng_(seed, 3),
      narrow_(table(filter.sigma_hit, filter)),
      wide_(table(filter.sigma_search, filter)),
      particles_(static_cast<std::size_t>(filter.particles_max)),
      drawn_(static_cast<std::size_t>(filter.particles_max)) {}

ParticleFilter::Particle ParticleFilter::drawn(const Spread& spread) noexcept {
  const double radius = spread.radius * std::sqrt(rng_.uniform());
  const double direction = 2.0 * std::numbers::pi * rng_.uniform();
  const double turn = spread.angle * (2.0 * rng_.uniform() - 1.0);
  return {spread.center.x + radius * std::cos(direction), spread.center.y + radius * std::sin(direction),
          wrap_angle(spread.center.yaw + turn), 0.0};
}

void ParticleFilter::scatter(const Spread& spread) noexcept {
  particles_.clear();
  const Spread at_center{spread.center, 0.05 * spread.radius, 0.05 * spread.angle};
  for (std::size_t i = 0; i < particles_.capacity(); ++i) particles_.push(drawn(i % 4 == 0 ? at_center : spread));
}

void ParticleFilter::move(double speed, double yaw_rate, double dt) noexcept {
  const double speed_std = motion_.speed_noise + motion_.speed_ratio * std::abs(speed);
  const double rate_std = motion_.yaw_rate_noise + motion_.yaw_rate_ratio * std::abs(yaw_rate);
  const double lateral_std = 0.1 * motion_.speed_noise + motion_.lateral_ratio * std::abs(speed);
  for (Particle& p : particles_) {
    Motion motion = motion_of(speed, yaw_rate, motion_.slip, dt);
    motion.ahead += speed_std * dt * rng_.gaussian();
    motion.left += lateral_std * dt * rng_.gaussian();
    motion.turn += rate_std * dt * rng_.gaussian();
    const Pose2 pose = moved({p.x, p.y, p.yaw}, motion);
    p.x = pose.x;
    p.y = pose.y;
    p.yaw = wrap_angle(pose.yaw);
  }
}

void ParticleFilter::shift(const Motion& motion) noexcept {
  for (Particle& p : particles_) {
    const Pose2 pose = moved({p.x, p.y, p.yaw}, motion);
    p.x = pose.x;
    p.y = pose.y;
    p.yaw = wrap_angle(pose.yaw);
  }
}

void ParticleFilter::weigh(std::span<const Beam> beams, bool searching) noexcept {
  const Table& log_likelihood = searching ? wide_ : narrow_;
  for (Particle& p : particles_) {
    const auto c = static_cast<float>(std::cos(p.yaw)), s = static_cast<float>(std::sin(p.yaw));
    const auto x = static_cast<float>(p.x), y = static_cast<float>(p.y);
    float sum = 0.0F;
    for (const Beam& b : beams) {
      const int mm = field_->distance_mm(x + c * b.x - s * b.y, y + s * b.x + c * b.y);
      sum += log_likelihood[static_cast<std::size_t>(mm)];
    }
    p.weight = static_cast<double>(sum);
  }
  normalize();
}

void ParticleFilter::normalize() noexcept {
  double top = -1e300, sum = 0.0;
  for (const Particle& p : particles_) top = std::max(top, p.weight);
  for (Particle& p : particles_) sum += p.weight = std::exp(p.weight - top);
  for (Particle& p : particles_) p.weight /= sum;
}

bool ParticleFilter::near(const Particle& p, const Pose2& center) const noexcept {
  return norm(p.x - center.x, p.y - center.y) < params_.cluster_radius &&
         std::abs(wrap_angle(p.yaw - center.yaw)) < params_.cluster_angle;
}

Cluster ParticleFilter::mean_around(const Pose2& center) const noexcept {
  double w = 0.0, x = 0.0, y = 0.0, turn = 0.0, xx = 0.0, tt = 0.0;
  for (const Particle& p : particles_) {
    if (!near(p, center)) continue;
    const double dx = p.x - center.x, dy = p.y - center.y, dt = wrap_angle(p.yaw - center.yaw);
    w += p.weight;
    x += p.weight * dx;
    y += p.weight * dy;
    turn += p.weight * dt;
    xx += p.weight * (dx * dx + dy * dy);
    tt += p.weight * dt * dt;
  }
  if (!(w > 0.0)) return {.pose = center};
  x /= w;
  y /= w;
  turn /= w;
  return {.pose = {center.x + x, center.y + y, wrap_angle(center.yaw + turn)},
          .std = std::sqrt(std::max(0.0, xx / w - x * x - y * y)),
          .std_yaw = std::sqrt(std::max(0.0, tt / w - turn * turn)),
          .share = w};
}

Cluster ParticleFilter::cluster() const noexcept {
  if (particles_.empty()) return {};
  const Particle* best = std::max_element(particles_.begin(), particles_.end(),
                                          [](const Particle& a, const Particle& b) { return a.weight < b.weight; });
  return mean_around(mean_around({best->x, best->y, best->yaw}).pose);
}

void ParticleFilter::resample(std::size_t count, std::span<const Spread> fresh) noexcept {
  if (particles_.empty()) return;
  count = std::min(count, drawn_.capacity());
  drawn_.clear();
  for (const Spread& spread : fresh) {
    const auto wanted = static_cast<std::size_t>(spread.share * static_cast<double>(count));
    for (std::size_t k = 0; k < wanted && drawn_.size() < count; ++k) drawn_.push(drawn(spread));
  }
  // Low-variance resampling: one random number, equal steps through the weights.
  const double step = 1.0 / static_cast<double>(std::max<std::size_t>(count - drawn_.size(), 1));
  double target = step * rng_.uniform(), sum = particles_[0].weight;
  for (std::size_t i = 0; drawn_.size() < count; target += step) {
    while (sum < target && i + 1 < particles_.size()) sum += particles_[++i].weight;
    drawn_.push(particles_[i]);
  }
  std::swap(particles_, drawn_);
}

}  // namespace firstlap::localization
