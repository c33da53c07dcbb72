#include "firstlap/sim/sensors.hpp"

#include <algorithm>

namespace firstlap::sim {

Sensors::Sensors(const SensorParams& params, std::uint64_t seed) : params_(params), rng_(seed, 2) {
  validate(params, "sensors");
}

void Sensors::change(const SensorParams& params) {
  validate(params, "sensors");
  params_ = params;
}

void Sensors::record(double time, const VehicleState& truth) noexcept {
  samples_[count_ % samples_.size()] = {time, truth};
  ++count_;
}

VehicleState Sensors::measure(double time) noexcept {
  if (count_ == 0) return {};
  const std::size_t kept = std::min(count_, samples_.size());
  std::size_t age = 1;
  while (age < kept && samples_[(count_ - age) % samples_.size()].time > time - params_.latency + 1e-9) ++age;
  const VehicleState truth = samples_[(count_ - age) % samples_.size()].state;
  return {truth.speed * (1.0 + params_.speed_scale_error) + params_.speed_noise * rng_.gaussian(),
          truth.yaw_rate + params_.yaw_rate_bias + params_.yaw_rate_noise * rng_.gaussian(),
          truth.steering_angle + params_.steering_offset + params_.steering_noise * rng_.gaussian()};
}

}  // namespace firstlap::sim
