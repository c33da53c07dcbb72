// Synthetic tracks: straight pieces of wall with known sides, the medial line between them, and a brute-force ray
// caster. Deliberately shares no code with the simulator or the method.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "firstlap/drivers/racer.hpp"

namespace firstlap::scene {

inline constexpr double pi = std::numbers::pi;
inline constexpr int right = -1;
inline constexpr int neither = 0;  // visible, but no wall of the track
inline constexpr int left = 1;

inline Point2 to_world(const Pose2& car, double x, double y) {
  return {car.x + std::cos(car.yaw) * x - std::sin(car.yaw) * y, car.y + std::sin(car.yaw) * x + std::cos(car.yaw) * y};
}

// A scan that owns its ranges.
struct Scan {
  double angle_min = -0.75 * pi;
  double angle_increment = 1.5 * pi / 1080.0;
  double range_min = 0.02;
  double range_max = 30.0;
  std::vector<float> ranges{};

  [[nodiscard]] LaserScan view() const { return {angle_min, angle_increment, 0.0, range_min, range_max, ranges}; }
  [[nodiscard]] Scan mirrored() const {
    Scan other = *this;
    other.angle_min = -(angle_min + angle_increment * static_cast<double>(ranges.size() - 1));
    std::reverse(other.ranges.begin(), other.ranges.end());
    return other;
  }
};

struct Wall {
  Point2 a;
  Point2 b;
  int side = neither;
};

inline double distance_to(const Wall& wall, Point2 p) {
  const double dx = wall.b.x - wall.a.x;
  const double dy = wall.b.y - wall.a.y;
  const double length2 = std::max(dx * dx + dy * dy, 1e-12);
  const double t = std::clamp(((p.x - wall.a.x) * dx + (p.y - wall.a.y) * dy) / length2, 0.0, 1.0);
  return std::hypot(p.x - wall.a.x - t * dx, p.y - wall.a.y - t * dy);
}

class Scene {
 public:
  Scene& add(int side, const std::vector<Point2>& corners) {
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) walls.push_back({corners[i], corners[i + 1], side});
    return *this;
  }
  Scene& box(int side, double x, double y, double length, double width) {
    return add(side, {{x, y}, {x + length, y}, {x + length, y + width}, {x, y + width}, {x, y}});
  }

  // Distance to the walls of one side; infinite if there are none.
  [[nodiscard]] double distance(int side, Point2 p) const {
    double best = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls)
      if (wall.side == side) best = std::min(best, distance_to(wall, p));
    return best;
  }

  // `car` is base_link, the LiDAR is `laser_x` ahead of it. Infinite without a hit.
  [[nodiscard]] Scan scan(const Pose2& car, double laser_x = CarGeometry{}.laser_x) const {
    Scan scan;
    const Point2 laser = to_world(car, laser_x, 0.0);
    for (int i = 0; i <= 1080; ++i)
      scan.ranges.push_back(static_cast<float>(cast(laser, car.yaw + scan.angle_min + i * scan.angle_increment)));
    return scan;
  }

  std::vector<Wall> walls{};

 private:
  [[nodiscard]] double cast(Point2 from, double angle) const {
    const double cx = std::cos(angle);
    const double cy = std::sin(angle);
    double best = std::numeric_limits<double>::infinity();
    for (const Wall& wall : walls) {
      const double ex = wall.b.x - wall.a.x;
      const double ey = wall.b.y - wall.a.y;
      const double ax = wall.a.x - from.x;
      const double ay = wall.a.y - from.y;
      const double det = ex * cy - ey * cx;
      if (std::abs(det) < 1e-12) continue;
      const double along_ray = (ex * ay - ey * ax) / det;
      const double along_wall = (cx * ay - cy * ax) / det;
      if (along_ray > 0.0 && along_wall >= 0.0 && along_wall <= 1.0) best = std::min(best, along_ray);
    }
    return best;
  }
};

// The medial line of a track, composed of straights and arcs (angle > 0 turns left). It starts at the origin toward +x.
class Course {
 public:
  Course() { poses_.push_back({0.0, 0.0, 0.0}); }
  Course& straight(double length) {
    const Pose2 p = poses_.back();
    const int pieces = std::max(1, static_cast<int>(length / 0.5));
    for (int i = 1; i <= pieces; ++i) {
      const double d = length * i / pieces;
      push({p.x + d * std::cos(p.yaw), p.y + d * std::sin(p.yaw), p.yaw});
    }
    return *this;
  }
  Course& turn(double radius, double angle) {
    const Pose2 p = poses_.back();
    const double sign = angle > 0.0 ? 1.0 : -1.0;
    const double cx = p.x - sign * radius * std::sin(p.yaw);
    const double cy = p.y + sign * radius * std::cos(p.yaw);
    const int pieces = std::max(2, static_cast<int>(std::abs(angle) / 0.04));
    for (int i = 1; i <= pieces; ++i) {
      const double yaw = p.yaw + angle * i / pieces;
      push({cx + sign * radius * std::sin(yaw), cy - sign * radius * std::cos(yaw), yaw});
    }
    return *this;
  }

  [[nodiscard]] double length() const { return s_.back(); }
  // base_link on the medial line, with its heading.
  [[nodiscard]] Pose2 at(double s, double offset = 0.0) const {
    std::size_t i = 1;
    while (i + 1 < s_.size() && s_[i] < s) ++i;
    const double t = (s - s_[i - 1]) / std::max(s_[i] - s_[i - 1], 1e-9);
    const Pose2& a = poses_[i - 1];
    const Pose2& b = poses_[i];
    const double yaw = a.yaw + t * (b.yaw - a.yaw);
    return {a.x + t * (b.x - a.x) - offset * std::sin(yaw), a.y + t * (b.y - a.y) + offset * std::cos(yaw), yaw};
  }
  // The curve offset by `offset` to the left, from s0 to s1.
  [[nodiscard]] std::vector<Point2> parallel(double offset, double s0, double s1) const {
    std::vector<Point2> line;
    const auto push_at = [&](double s) {
      const Pose2 p = at(s, offset);
      line.push_back({p.x, p.y});
    };
    push_at(s0);
    for (double s : s_)
      if (s > s0 && s < s1) push_at(s);
    push_at(s1);
    return line;
  }
  [[nodiscard]] Scene walls(double width) const {
    Scene scene;
    scene.add(scene::left, parallel(0.5 * width, 0.0, length()));
    scene.add(scene::right, parallel(-0.5 * width, 0.0, length()));
    return scene;
  }
  // Walls of separate pipes with joints between them; those on the left are shifted by half a pipe.
  [[nodiscard]] Scene pipes(double width, double pipe, double joint) const {
    Scene scene;
    for (double s = 0.0; s < length(); s += pipe + joint) {
      scene.add(scene::right, parallel(-0.5 * width, s, std::min(s + pipe, length())));
      const double half = s + 0.5 * pipe;
      if (half < length()) scene.add(scene::left, parallel(0.5 * width, half, std::min(half + pipe, length())));
    }
    return scene;
  }
  // Distance of a point to the medial line.
  [[nodiscard]] double distance(Point2 p) const {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < poses_.size(); ++i)
      best = std::min(best, distance_to({{poses_[i - 1].x, poses_[i - 1].y}, {poses_[i].x, poses_[i].y}, neither}, p));
    return best;
  }

 private:
  void push(const Pose2& p) {
    s_.push_back(s_.back() + std::hypot(p.x - poses_.back().x, p.y - poses_.back().y));
    poses_.push_back(p);
  }
  std::vector<Pose2> poses_;
  std::vector<double> s_{0.0};
};

// Evaluation of traces. ---------------------------------------------------------------------------------

// Number of samples in this scan, at most 1 m behind the rear axle, that are closer to a wall of the other side, or to
// one that is no wall of the track, than to one of their own side.
struct Labels {
  int right_ones = 0;
  int wrong_ones = 0;
};

inline Labels count_labels(const Trace& trace, const Scene& scene, const Pose2& car, double radius = 1e9) {
  Labels labels;
  const auto count = [&](const WallSide& side, int name) {
    for (std::size_t i = 0; i < side.size(); ++i) {
      const auto x = static_cast<double>(side.x[i]);
      const auto y = static_cast<double>(side.y[i]);
      if (side.age[i] > 0.0F || std::hypot(x, y) > radius || x < -1.0) continue;
      const Point2 p = to_world(car, x, y);
      const double own = scene.distance(name, p);
      const bool good = own <= scene.distance(-name, p) && own <= scene.distance(neither, p);
      (good ? labels.right_ones : labels.wrong_ones)++;
    }
  };
  count(trace.walls.right, right);
  count(trace.walls.left, left);
  return labels;
}

// Largest distance of the centerline from the medial line, over the first `reach` meters ahead.
inline double line_error(const Trace& trace, const Course& course, const Pose2& car, double reach) {
  double worst = 0.0;
  double s = 0.0;
  for (std::size_t i = trace.line.nearest; i < trace.line.points.size(); ++i) {
    const CenterlinePoint& p = trace.line.points[i];
    if (i > trace.line.nearest) s += std::hypot(p.x - trace.line.points[i - 1].x, p.y - trace.line.points[i - 1].y);
    if (s > reach) break;
    worst = std::max(worst, course.distance(to_world(car, p.x, p.y)));
  }
  return worst;
}

// Statistics of a drive along a course.
struct Tour {
  int steps = 0;
  int not_ok = 0;           // steps whose status was not ok
  double worst_line = 0.0;  // [m] of line_error over 2 m
  double worst_at = 0.0;    // [m] along the course
  int short_lines = 0;      // steps with less than 1.5 m of line ahead
  int wrong_labels = 0;     // samples within 4 m
  int labels = 0;
  double worst_offset = 0.0;  // [m] of the car from the medial line, for a car that drives itself
};

inline void evaluate(const Racer& racer, const StepResult& result, const Scene& scene, const Course& course,
                     const Pose2& car, double s, Tour& tour) {
  ++tour.steps;
  tour.not_ok += result.status != Status::ok;
  tour.short_lines += racer.trace().line.ahead < 1.5;
  const double error = line_error(racer.trace(), course, car, 2.0);
  if (error > tour.worst_line) {
    tour.worst_line = error;
    tour.worst_at = s;
  }
  const Labels labels = count_labels(racer.trace(), scene, car, 4.0);
  tour.wrong_labels += labels.wrong_ones;
  tour.labels += labels.wrong_ones + labels.right_ones;
}

// Moves the car along the medial line at constant speed. `spoil(scan, k)` may change scan k.
template <class Spoil>
Tour carry(Racer& racer, const Scene& scene, const Course& course, double from, double to, double speed, Spoil spoil) {
  constexpr double dt = 0.025;
  Tour tour;
  int k = 0;
  for (double s = from; s < to; s += speed * dt, ++k) {
    const Pose2 car = course.at(s);
    const double yaw_rate = (car.yaw - course.at(s - speed * dt).yaw) / dt;
    Scan scan = scene.scan(car);
    spoil(scan, k);
    const StepResult result = racer.step(scan.view(), {speed, yaw_rate, 0.0}, dt);
    evaluate(racer, result, scene, course, car, s, tour);
  }
  return tour;
}
inline Tour carry(Racer& racer, const Scene& scene, const Course& course, double from, double to, double speed = 2.0) {
  return carry(racer, scene, course, from, to, speed, [](Scan&, int) {});
}

// Lets the car drive as a kinematic bicycle without delays. Ends after `steps`, or when the car is more than 3 m off
// the medial line.
inline Tour drive(Racer& racer, const Scene& scene, const Course& course, double from, double to, double speed) {
  constexpr double dt = 0.025;
  const double wheelbase = racer.params().car.wheelbase;
  Tour tour;
  Pose2 car = course.at(from);
  double traveled = from;
  double yaw_rate = 0.0;
  double wheel = 0.0;
  while (traveled < to && tour.worst_offset < 3.0 && tour.steps < 4000) {
    const StepResult result = racer.step(scene.scan(car).view(), {speed, yaw_rate, wheel}, dt);
    evaluate(racer, result, scene, course, car, traveled, tour);
    speed += std::clamp(result.command.speed - speed, -0.15, 0.15);
    wheel = result.command.steering_angle;
    yaw_rate = speed * std::tan(wheel) / wheelbase;
    const double middle = car.yaw + 0.5 * yaw_rate * dt;
    car = {car.x + speed * dt * std::cos(middle), car.y + speed * dt * std::sin(middle), car.yaw + yaw_rate * dt};
    traveled += std::max(speed * dt, 0.002);
    tour.worst_offset = std::max(tour.worst_offset, course.distance({car.x, car.y}));
  }
  return tour;
}

}  // namespace firstlap::scene
