#include "firstlap/control/stopping_check.hpp"

#include <algorithm>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

constexpr double step = 0.025;          // [s]
constexpr double dead_time = 0.05;      // [s] from command to wheels
constexpr double servo = 0.08;          // [s] in which the wheels come to where they are told
constexpr double standing = 0.05;       // [m/s]
constexpr double creeping = 0.5;        // [m/s] a car that stands is about to go at least this fast
constexpr std::size_t most_steps = 80;  // 2 s: with less braking than that the horizon is too near anyway

// The body as four discs on its long axis, which cover the rectangle.
class Body {
 public:
  explicit Body(const CarGeometry& car) noexcept
      : first_(car.length / 8.0 - car.rear_overhang),
        apart_(car.length / 4.0),
        radius_(norm(0.5 * car.width, car.length / 8.0)) {}

  [[nodiscard]] double clearance(const Pose2& pose, const LocalWalls& walls) const noexcept {
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    double nearest = 1e9;
    for (int i = 0; i < 4; ++i) {
      const double along = first_ + static_cast<double>(i) * apart_;
      const double x = pose.x + along * c;
      const double y = pose.y + along * s;
      nearest =
          std::min({nearest, nearest_sample(walls.left, x, y).distance, nearest_sample(walls.right, x, y).distance});
    }
    return nearest - radius_;
  }

 private:
  double first_;
  double apart_;
  double radius_;
};

// The wheel angle that brings the rear axle onto the path `ahead` of it (pure pursuit), no sharper than the grip
// allows.
double wheels_to_path(const Buffer<TrajectoryPoint>& path, std::size_t& at, const Pose2& pose, double speed,
                      const CarGeometry& car, const VelocityProfileParams& params) noexcept {
  const double reach = car.wheelbase + 0.15 + 0.15 * speed;
  while (at + 1 < path.size() && norm(path[at].x - pose.x, path[at].y - pose.y) < reach) ++at;
  const double dx = path[at].x - pose.x;
  const double dy = path[at].y - pose.y;
  const double across = std::cos(pose.yaw) * dy - std::sin(pose.yaw) * dx;
  const double bend = 2.0 * across / std::max(dx * dx + dy * dy, 1e-3);
  return within_grip(std::atan(car.wheelbase * bend), speed, car, params);
}

// What full braking comes to: a bend takes its share of the grip, and the speed loop lets go before the car stands.
double braking(double speed, double bend, const VelocityProfileParams& params) noexcept {
  constexpr double release = 6.0;  // [1/s]
  const double used = speed * speed * bend / (2.0 * params.a_y_max);
  const double grip = std::sqrt(std::max(0.2, 1.0 - used * used));
  return std::min(params.a_brake * grip, release * speed);
}

// The car on its way to the stop, from base_link at the scan.
struct Rollout {
  Pose2 pose{};
  double speed = 0.0;   // [m/s]
  double wheels = 0.0;  // [rad]
  double bend = 0.0;    // [1/m]
  double driven = 0.0;  // [m]

  void advance(double wanted, bool brakes, const CarGeometry& car, const VelocityProfileParams& params) noexcept {
    const double most = car.steering_rate * step;
    wheels += std::clamp((wanted - wheels) * step / servo, -most, most);
    bend = std::tan(wheels) / car.wheelbase;
    const double way = speed * step;
    const double yaw = way * bend;
    pose.x += way * std::cos(pose.yaw + 0.5 * yaw);
    pose.y += way * std::sin(pose.yaw + 0.5 * yaw);
    pose.yaw += yaw;
    driven += way;
    if (brakes) speed -= braking(speed, bend, params) * step;
  }

  // How far any point of the body moves per meter driven, at most.
  [[nodiscard]] double swing(const CarGeometry& car) const noexcept { return 1.0 + std::abs(bend) * car.length; }
};

}  // namespace

double within_grip(double angle, double speed, const CarGeometry& car, const VelocityProfileParams& params) noexcept {
  constexpr double reserve = 1.3;  // of what the profile plans to use
  const double bend = reserve * params.a_y_max / std::max(speed * speed, 1e-3);
  const double limit = std::min(car.steering_limit, std::atan(car.wheelbase * bend));
  return std::clamp(angle, -limit, limit);
}

StoppingCheck check_stopping(const StopScene& scene, const Stop& stop, const CarGeometry& car,
                             const VelocityProfileParams& params) noexcept {
  const Body body(car);
  StoppingCheck found;
  Rollout rollout{.speed = std::max(creeping, scene.state.speed), .wheels = scene.state.steering_angle};
  double room = body.clearance(rollout.pose, scene.walls);
  const double needed = std::min(params.stop_clearance, room - 0.002);
  double checked = 0.0;  // [m] of the way, there with `room` around it
  bool braked = false;
  std::size_t at = scene.nearest;
  for (std::size_t k = 0; k < most_steps && rollout.speed > standing; ++k) {
    const double time = static_cast<double>(k) * step;
    const bool brakes = time >= stop.delay;
    double wanted = brakes || time < dead_time ? rollout.wheels : stop.command;
    // Beyond the end of the path nobody knows better than to hold the wheels.
    if (brakes && stop.how == StopSteering::to_path && at + 1 < scene.path.size())
      wanted = wheels_to_path(scene.path, at, rollout.pose, rollout.speed, car, params);
    if (brakes && stop.how == StopSteering::straight) wanted = 0.0;
    if (brakes && !braked) found.wheels = wanted;
    braked = brakes;
    rollout.advance(wanted, brakes, car, params);
    // Until it has come as far as there was room, nothing can be touched.
    if ((rollout.driven - checked) * rollout.swing(car) < room - needed) continue;
    room = body.clearance(rollout.pose, scene.walls);
    checked = rollout.driven;
    found.clearance = std::min(found.clearance, room);
    if (room >= needed) continue;
    found.clear = false;
    found.distance = rollout.driven;
    return found;
  }
  return found;
}

StopDecision decide_stop(const StopScene& scene, double wanted, double dt, bool braking, const CarGeometry& car,
                         const VelocityProfileParams& params) noexcept {
  constexpr double reaction = 0.05;  // [s] from command to wheels and brakes
  VelocityProfileParams reserved = params;
  if (braking) reserved.a_brake *= 0.8;
  const auto check = [&](StopSteering how, double delay) {
    return check_stopping(scene, {wanted, delay, how}, car, reserved);
  };
  if (check(StopSteering::to_path, dt + reaction).clear) return {false, wanted};
  StoppingCheck best = check(StopSteering::to_path, reaction);
  for (const StopSteering how : {StopSteering::kept, StopSteering::straight}) {
    if (best.clear) break;
    const StoppingCheck other = check(how, reaction);
    if (other.clear || other.distance > best.distance) best = other;
  }
  return {true, best.wheels};
}

}  // namespace firstlap
