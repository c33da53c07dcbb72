#include "firstlap/sim/vehicle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace firstlap::sim {
namespace {

constexpr double gym_control_period = 0.01;  // [s]

BodyState moved(const BodyState& q, const BodyState& d, double h) noexcept {
  return {q.x + h * d.x,
          q.y + h * d.y,
          q.yaw + h * d.yaw,
          q.forward + h * d.forward,
          q.lateral + h * d.lateral,
          q.yaw_rate + h * d.yaw_rate,
          q.steering + h * d.steering};
}

GymState moved(GymState q, const GymState& d, double h) noexcept {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += h * d[i];
  return q;
}

// Classical Runge-Kutta of order 4.
template <class State, class Derivative>
State runge_kutta(const State& q, double h, Derivative&& derivative) noexcept {
  const State k1 = derivative(q);
  const State k2 = derivative(moved(q, k1, 0.5 * h));
  const State k3 = derivative(moved(q, k2, 0.5 * h));
  const State k4 = derivative(moved(q, k3, h));
  return moved(moved(moved(moved(q, k1, h / 6.0), k2, h / 3.0), k3, h / 3.0), k4, h / 6.0);
}

}  // namespace

Pose2 between(const Pose2& a, const Pose2& b, double t) noexcept {
  const double turn = std::remainder(b.yaw - a.yaw, 2.0 * std::numbers::pi);
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.yaw + t * turn};
}

Vehicle::Vehicle(const CarGeometry& geometry, const VehicleParams& params) : geometry_(geometry), params_(params) {
  validate(geometry, "car");
  validate(params, "vehicle");
  if (std::abs(params.l_f + params.l_r - geometry.wheelbase) > 1e-3) {
    throw std::invalid_argument("vehicle.l_f + vehicle.l_r must be geometry.wheelbase");
  }
  reset({});
}

void Vehicle::reset(const Pose2& base_link, double speed) {
  const double x = base_link.x + params_.l_r * std::cos(base_link.yaw);
  const double y = base_link.y + params_.l_r * std::sin(base_link.yaw);
  body_ = {.x = x, .y = y, .yaw = base_link.yaw, .forward = speed};
  gym_ = {x, y, 0.0, speed, base_link.yaw, 0.0, 0.0};
  gym_input_ = {};
  gym_buffer_ = {};
  gym_next_control_ = 0.0;
  steering_line_.reset(0.0);
  speed_line_.reset(speed);
  time_ = a_x_ = a_y_ = yaw_acceleration_ = 0.0;
}

void Vehicle::change(const CarGeometry& geometry, const VehicleParams& params) {
  const Vehicle checked(geometry, params);
  if (params.model != params_.model) throw std::invalid_argument("vehicle.model cannot change while the car moves");
  const double ahead = params.l_r - params_.l_r;
  gym_[0] = body_.x += ahead * std::cos(body_.yaw);
  gym_[1] = body_.y += ahead * std::sin(body_.yaw);
  geometry_ = geometry;
  params_ = params;
}

void Vehicle::command(const DriveCommand& command, double latency) noexcept {
  if (!std::isfinite(command.speed) || !std::isfinite(command.steering_angle)) return;
  const double steering = params_.steering_gain * command.steering_angle + params_.steering_trim;
  const double speed = (1.0 + params_.speed_constant_error) * command.speed;
  steering_line_.push(time_ + latency + params_.steering_delay, steering);
  speed_line_.push(time_ + latency + params_.speed_delay, speed);
}

void Vehicle::kick(double lateral_speed, double yaw_rate) noexcept {
  if (!std::isfinite(lateral_speed) || !std::isfinite(yaw_rate)) return;
  body_.lateral += lateral_speed;
  body_.yaw_rate += yaw_rate;
  gym_[5] += yaw_rate;
  if (std::abs(gym_[3]) > 0.5) gym_[6] += std::atan2(lateral_speed, gym_[3]);
}

void Vehicle::step(double dt) noexcept {
  if (params_.model == static_cast<int>(VehicleModel::gym)) {
    step_gym(dt);
  } else {
    step_single_track(dt);
  }
  time_ += dt;
}

void Vehicle::step_single_track(double dt) noexcept {
  const double speed = speed_line_.at(time_), steering = steering_line_.at(time_);
  const auto derivative = [&](const BodyState& q) {
    return single_track_derivative(geometry_, params_, q, speed, steering);
  };
  const BodyState rate = derivative(body_);
  a_x_ = rate.forward - body_.lateral * body_.yaw_rate;
  a_y_ = rate.lateral + body_.forward * body_.yaw_rate;
  yaw_acceleration_ = rate.yaw_rate;
  body_ = runge_kutta(body_, dt, derivative);
  const bool slow = std::hypot(body_.forward, body_.lateral) < params_.kinematic_below;
  if (slow && params_.reverse_speed_max == 0.0) body_.forward = std::max(body_.forward, 0.0);
}

void Vehicle::update_gym_input() noexcept {
  const double steering = gym_buffer_[1];
  gym_buffer_[1] = gym_buffer_[0];
  gym_buffer_[0] = steering_line_.at(time_);
  gym_input_ = gym_control(geometry_, params_, gym_, speed_line_.at(time_), steering);
  gym_next_control_ += gym_control_period;
}

void Vehicle::step_gym(double dt) noexcept {
  if (time_ + 1e-9 >= gym_next_control_) update_gym_input();
  const auto derivative = [&](const GymState& q) { return gym_derivative(geometry_, params_, q, gym_input_); };
  const GymState rate = derivative(gym_);
  a_x_ = rate[3];
  a_y_ = gym_[3] * (rate[4] + rate[6]);
  yaw_acceleration_ = rate[5];
  gym_ = runge_kutta(gym_, dt, derivative);
  body_ = {gym_[0], gym_[1], gym_[4], gym_[3] * std::cos(gym_[6]), gym_[3] * std::sin(gym_[6]), gym_[5], gym_[2]};
}

Pose2 Vehicle::pose() const noexcept {
  return {body_.x - params_.l_r * std::cos(body_.yaw), body_.y - params_.l_r * std::sin(body_.yaw),
          std::remainder(body_.yaw, 2.0 * std::numbers::pi)};
}

VehicleState Vehicle::state() const noexcept { return {body_.forward, body_.yaw_rate, body_.steering}; }

VehicleState Vehicle::own_state() const noexcept {
  return {body_.forward / (1.0 + params_.speed_constant_error), body_.yaw_rate,
          (body_.steering - params_.steering_trim) / params_.steering_gain};
}

Point2 Vehicle::acceleration_at(double x) const noexcept {
  const double ahead = x - params_.l_r;
  return {a_x_ - ahead * body_.yaw_rate * body_.yaw_rate, a_y_ + ahead * yaw_acceleration_};
}

double Vehicle::lateral_speed() const noexcept { return body_.lateral - params_.l_r * body_.yaw_rate; }

}  // namespace firstlap::sim
