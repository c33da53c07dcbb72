#include "firstlap/sim/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firstlap::sim {
namespace {

VehicleState misread(VehicleState state, double yaw, OdometryFault fault) noexcept {
  constexpr double km_h_per_m_s = 3.6;
  switch (fault) {
    case OdometryFault::none: break;
    case OdometryFault::negated: state.speed = -state.speed; break;
    case OdometryFault::map_frame: state.speed *= std::cos(yaw); break;
    case OdometryFault::km_h: state.speed *= km_h_per_m_s; break;
    case OdometryFault::deg_s: state.yaw_rate *= 180.0 / std::numbers::pi; break;
    case OdometryFault::stuck: state = {0.0, 0.0, state.steering_angle}; break;
  }
  return state;
}

}  // namespace

Sensors::Sensors(const SensorParams& params, std::uint64_t seed) : params_(params), rng_(seed, 2) {
  validate(params, "sensors");
}

void Sensors::change(const SensorParams& params) {
  validate(params, "sensors");
  params_ = params;
}

void Sensors::record(double time, const VehicleState& state, double yaw) noexcept {
  samples_[count_ % samples_.size()] = {time, state, yaw};
  ++count_;
}

VehicleState Sensors::measure(double time) noexcept {
  if (count_ == 0) return {};
  const std::size_t kept = std::min(count_, samples_.size());
  std::size_t age = 1;
  while (age < kept && samples_[(count_ - age) % samples_.size()].time > time - params_.latency + 1e-9) ++age;
  const Sample& then = samples_[(count_ - age) % samples_.size()];
  const VehicleState& truth = then.state;
  const VehicleState measured{
      truth.speed * (1.0 + params_.speed_scale_error) + params_.speed_noise * rng_.gaussian(),
      truth.yaw_rate + params_.yaw_rate_bias + params_.yaw_rate_noise * rng_.gaussian(),
      truth.steering_angle + params_.steering_offset + params_.steering_noise * rng_.gaussian()};
  return misread(measured, then.yaw, static_cast<OdometryFault>(params_.odometry_fault));
}

}  // namespace firstlap::sim
