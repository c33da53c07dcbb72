#include "firstlap/drivers/racer_memory.hpp"

#include <cmath>

namespace firstlap {
namespace {

void forget(LocalWalls& walls) noexcept {
  walls.left.clear();
  walls.right.clear();
}

// Transforms points into the base_link that `motion` leads to.
class Mover {
 public:
  explicit Mover(const Pose2& motion) noexcept : motion_(motion), c_(std::cos(motion.yaw)), s_(std::sin(motion.yaw)) {}

  template <class Point>
  void move(Point& p) const noexcept {
    const double dx = p.x - motion_.x;
    const double dy = p.y - motion_.y;
    p.x = c_ * dx + s_ * dy;
    p.y = -s_ * dx + c_ * dy;
    p.yaw -= motion_.yaw;
  }

 private:
  Pose2 motion_;
  double c_;
  double s_;
};

void move_trail(const Mover& mover, double dt, double longest, Buffer<TrailPoint>& trail) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < trail.size(); ++i) {
    TrailPoint p = trail[i];
    mover.move(p);
    p.age += dt;
    if (p.age < longest) trail[kept++] = p;
  }
  trail.shrink(kept);
}

void extend_trail(double driven, double spacing, RacerMemory& memory) noexcept {
  memory.since_trail_point += driven;
  if (memory.since_trail_point <= spacing && !memory.trail.empty()) return;
  memory.trail.push({0.0, 0.0, 0.0, 0.0});
  memory.since_trail_point = 0.0;
}

}  // namespace

double learn_from_driving(const VehicleState& measured, double dt, const CarDynamics& car,
                          const SpeedScaleParams& params, RacerMemory& memory) noexcept {
  expect_speed(memory.command.speed, dt, car, memory.speed_scale);
  learn_from_command(measured.speed, dt, params, memory.speed_scale);
  return measured_speed_scale(memory.speed_scale, params);
}

void move_by_odometry(const VehicleState& state, double scale, double dt, const CenterlineParams& params,
                      RacerMemory& memory) noexcept {
  const double yaw_rate = 0.5 * (state.yaw_rate + (memory.initialized ? memory.measured.yaw_rate : state.yaw_rate));
  const double speed = 0.5 * (state.speed + (memory.initialized ? memory.speed : state.speed));
  const double turn = yaw_rate * dt;
  const Pose2 motion{speed * dt * std::cos(0.5 * turn), speed * dt * std::sin(0.5 * turn), turn};
  move_walls(motion, dt, memory.path_walls);
  move_walls(motion, dt, memory.last_walls);
  const Mover mover(motion);
  for (TrajectoryPoint& p : memory.path) mover.move(p);
  move_trail(mover, dt, params.trail_time, memory.trail);
  extend_trail(std::abs(speed) * dt, params.trail_spacing, memory);
  memory.time_without_path += dt;
  memory.moved += speed * dt;
  memory.moved_measured += speed / scale * dt;
}

void learn_from_scan(const Buffer<SectionSample>& samples, double dt, const SpeedScaleParams& params,
                     RacerMemory& memory) noexcept {
  if (params.scale_limit <= 0.0) return;
  const MotionError error = forward_error(memory.last_walls, samples, memory.moved, params);
  learn_from_walls(error, {memory.moved, memory.moved_measured, dt}, params, memory.speed_scale);
}

// The first median is taken over as it is, later ones with the gain `width_gain`. If the track is too wide at most
// points, its width is `width_max`: the centerline must not jump where the track narrows below that.
bool learn_width(const Centerline& line, const TrackWidthParams& params, Buffer<double>& widths,
                 RacerMemory& memory) noexcept {
  widths.clear();
  std::size_t wide = 0;
  for (const CenterlinePoint& c : line.points) {
    wide += c.wide ? 1 : 0;
    if (c.support == WallSupport::both && c.width >= params.width_min) widths.push(c.width);
  }
  if (wide > widths.size()) widths.fill(wide, params.width_max);
  const double before = width_of(memory, params);
  const double gain = memory.width ? params.width_gain : 1.0;
  const double now = remember_width(before, {widths.data(), widths.size()}, gain, params);
  if (now == before) return false;
  memory.width = now;
  return true;
}

void forget_direction(RacerMemory& memory) noexcept {
  forget(memory.path_walls);
  memory.path.clear();
  memory.trail.clear();
}

void remember_walls(const LocalWalls& walls, RacerMemory& memory) noexcept {
  memory.last_walls = walls;
  memory.moved = memory.moved_measured = 0.0;
}

void remember_path(const Buffer<TrajectoryPoint>& path, const LocalWalls& walls, LineEnd end,
                   RacerMemory& memory) noexcept {
  memory.path = path;
  memory.path_walls = walls;
  memory.line_end = end;
  memory.time_without_path = 0.0;
}

}  // namespace firstlap
