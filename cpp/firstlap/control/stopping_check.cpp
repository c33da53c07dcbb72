#include "firstlap/control/stopping_check.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

// Numerics of the simulated stop.
constexpr double step = 0.025;         // [s]
constexpr std::size_t max_steps = 80;  // 2 s: if braking takes longer, the horizon is too close anyway
constexpr double standing = 0.05;      // [m/s] below this the car has stopped
constexpr double touching = 0.002;     // [m] by which a clearance below stop_clearance may still shrink
constexpr double tiny = 1e-3;          // [m^2], [m^2/s^2] lower bound of divisors

// The body as discs on its longitudinal axis that cover the rectangle.
class Body {
 public:
  explicit Body(const CarGeometry& car) noexcept
      : first_(0.5 * car.length / discs - car.rear_overhang),
        apart_(car.length / discs),
        radius_(norm(0.5 * car.width, 0.5 * car.length / discs)) {}

  [[nodiscard]] double clearance(const Pose2& pose, const LocalWalls& walls) const noexcept {
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    double nearest = StoppingCheck::never;
    for (int i = 0; i < discs; ++i) {
      const double along = first_ + static_cast<double>(i) * apart_;
      const double x = pose.x + along * c;
      const double y = pose.y + along * s;
      nearest =
          std::min({nearest, nearest_sample(walls.left, x, y).distance, nearest_sample(walls.right, x, y).distance});
    }
    return nearest - radius_;
  }

 private:
  static constexpr int discs = 4;

  double first_;
  double apart_;
  double radius_;
};

// State of the car during the stop, in base_link at the scan.
struct Rollout {
  Pose2 pose{};
  double speed = 0.0;      // [m/s]
  double steering = 0.0;   // [rad]
  double curvature = 0.0;  // [1/m]
  double driven = 0.0;     // [m]

  void advance(double wanted, bool brakes, const StopLimits& limits) noexcept;

  // Maximum displacement of any point of the body per meter driven.
  [[nodiscard]] double swing(const CarGeometry& car) const noexcept { return 1.0 + std::abs(curvature) * car.length; }
};

// [m/s^2] Deceleration of full braking. Cornering takes part of the grip, and the speed loop releases the brake before
// standstill.
double braking(double speed, double curvature, const StopLimits& limits) noexcept {
  const double used = speed * speed * curvature / (limits.check.grip_share * limits.profile.a_y_max);
  const double grip = std::sqrt(std::max(limits.check.grip_left, 1.0 - used * used));
  const double release = limits.car.speed_gain * limits.check.response_share;
  return std::min(std::min(limits.a_brake, limits.car.brake_max) * grip, release * speed);
}

void Rollout::advance(double wanted, bool brakes, const StopLimits& limits) noexcept {
  const double servo = limits.car.servo_time_constant / limits.check.response_share;
  const double most = limits.car.steering_rate * step;
  steering += std::clamp((wanted - steering) * step / std::max(servo, step), -most, most);
  curvature = std::tan(steering) / limits.car.wheelbase;
  const double distance = speed * step;
  const double yaw = distance * curvature;
  pose.x += distance * std::cos(pose.yaw + 0.5 * yaw);
  pose.y += distance * std::sin(pose.yaw + 0.5 * yaw);
  pose.yaw += yaw;
  driven += distance;
  if (brakes) speed -= braking(speed, curvature, limits) * step;
}

// Steering during the stop.
class Guide {
 public:
  Guide(const StopScene& scene, const Stop& stop, const StopLimits& limits) noexcept
      : scene_(scene), stop_(stop), limits_(limits), at_(scene.nearest) {}

  [[nodiscard]] bool brakes(double time) const noexcept { return time >= stop_.delay; }

  // [rad] The wanted steering angle. Before braking starts, it is the command, once that has passed the steering delay;
  // then it follows the strategy of the stop. Beyond the end of the path the angle is held.
  double wanted(double time, const Rollout& car) noexcept {
    if (!brakes(time)) return time < limits_.car.steering_delay ? car.steering : stop_.command;
    if (stop_.how == StopSteering::straight) return 0.0;
    const bool guided = stop_.how == StopSteering::track_path && at_ + 1 < scene_.path.size();
    return guided ? pursue(car) : car.steering;
  }

 private:
  // Steering angle [rad] of pure pursuit of the path ahead, limited by the grip.
  double pursue(const Rollout& car) noexcept {
    const Buffer<TrajectoryPoint>& path = scene_.path;
    const Pose2& pose = car.pose;
    const double reach = limits_.car.wheelbase + limits_.check.aim_distance + limits_.check.aim_time * car.speed;
    while (at_ + 1 < path.size() && norm(path[at_].x - pose.x, path[at_].y - pose.y) < reach) ++at_;
    const double dx = path[at_].x - pose.x;
    const double dy = path[at_].y - pose.y;
    const double across = std::cos(pose.yaw) * dy - std::sin(pose.yaw) * dx;
    const double curvature = 2.0 * across / std::max(dx * dx + dy * dy, tiny);
    return within_grip(std::atan(limits_.car.wheelbase * curvature), car.speed, limits_);
  }

  const StopScene& scene_;
  const Stop& stop_;
  const StopLimits& limits_;
  std::size_t at_;  // index of the pursued path point
};

}  // namespace

double within_grip(double angle, double speed, const StopLimits& limits) noexcept {
  const double curvature = limits.check.brake_bend_share * limits.profile.a_y_max / std::max(speed * speed, tiny);
  const double limit = std::min(limits.car.steering_limit, std::atan(limits.car.wheelbase * curvature));
  return std::clamp(angle, -limit, limit);
}

StoppingCheck check_stopping(const StopScene& scene, const Stop& stop, const StopLimits& limits) noexcept {
  const Body body(limits.car);
  Guide guide(scene, stop, limits);
  StoppingCheck found;
  Rollout car{.speed = std::max(limits.check.start_speed, scene.state.speed), .steering = scene.state.steering_angle};
  double clearance = body.clearance(car.pose, scene.walls);
  const double needed = std::min(limits.profile.stop_clearance, clearance - touching);
  double checked = 0.0;  // [m] driven up to the last clearance test
  bool braked = false;
  for (std::size_t k = 0; k < max_steps && car.speed > standing; ++k) {
    const double time = static_cast<double>(k) * step;
    const bool brakes = guide.brakes(time);
    const double wanted = guide.wanted(time, car);
    if (brakes && !braked) found.steering_angle = wanted;
    braked = brakes;
    car.advance(wanted, brakes, limits);
    // No contact is possible before the car has moved as far as its clearance.
    if ((car.driven - checked) * car.swing(limits.car) < clearance - needed) continue;
    clearance = body.clearance(car.pose, scene.walls);
    checked = car.driven;
    found.clearance = std::min(found.clearance, clearance);
    if (clearance >= needed) continue;
    found.clear = false;
    found.distance = car.driven;
    break;
  }
  return found;
}

StopDecision decide_stop(const StopScene& scene, double wanted, double dt, bool braking,
                         const StopLimits& limits) noexcept {
  StopLimits reserved = limits;
  if (braking) reserved.a_brake *= limits.check.release_share;
  const double reaction = std::max({limits.check.reaction_time, limits.car.steering_delay, limits.car.speed_delay});
  const auto check = [&](StopSteering how, double delay) {
    return check_stopping(scene, {wanted, delay, how}, reserved);
  };
  if (check(StopSteering::track_path, dt + reaction).clear) return {false, wanted};
  StoppingCheck best = check(StopSteering::track_path, reaction);
  for (const StopSteering how : {StopSteering::hold, StopSteering::straight}) {
    if (best.clear) break;
    const StoppingCheck other = check(how, reaction);
    if (other.clear || other.distance > best.distance) best = other;
  }
  return {true, best.steering_angle};
}

}  // namespace firstlap
