// Tracks and a driver for the simulator's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "firstlap/sim/race.hpp"

namespace firstlap::sim::testing {

// A wavy closed track, counterclockwise, about 94 m long; `points` on each of its two walls.
inline Track wavy_track(int points = 400, double half_width = 0.9, double waviness = 0.25) {
  std::vector<Point2> center, left, right;
  const double turn = 2.0 * std::numbers::pi;
  const auto at = [&](double angle) {
    const double radius = 11.6 * (1.0 + waviness * std::sin(3.0 * angle) + 0.3 * waviness * std::cos(7.0 * angle));
    return Point2{1.3 * radius * std::cos(angle), 0.75 * radius * std::sin(angle)};
  };
  for (int i = 0; i < points; ++i) {
    const Point2 p = at(turn * i / points), q = at(turn * i / points + 1e-5);
    const double norm = std::hypot(q.x - p.x, q.y - p.y), nx = -(q.y - p.y) / norm, ny = (q.x - p.x) / norm;
    center.push_back(p);
    left.push_back({p.x + half_width * nx, p.y + half_width * ny});
    right.push_back({p.x - half_width * nx, p.y - half_width * ny});
  }
  std::vector<WallSegment> segments;
  for (const auto& side : {left, right}) {
    for (std::size_t i = 0; i < side.size(); ++i) {
      const Point2 a = side[i], b = side[(i + 1) % side.size()];
      segments.push_back({a.x, a.y, b.x, b.y});
    }
  }
  return {Walls(std::move(segments)), std::move(center)};
}

// Two concentric circles as polygons, driven counterclockwise; the centerline has `radius` [m] and ten times the points
// of a wall.
inline Track annulus(double radius, double half_width, int points = 360) {
  std::vector<WallSegment> segments;
  std::vector<Point2> center;
  const double turn = 2.0 * std::numbers::pi;
  const auto at = [&](double r, double i) {
    return Point2{r * std::cos(turn * i / points), r * std::sin(turn * i / points)};
  };
  for (const double r : {radius + half_width, radius - half_width}) {
    for (int i = 0; i < points; ++i) {
      const Point2 a = at(r, i), b = at(r, i + 1);
      segments.push_back({a.x, a.y, b.x, b.y});
    }
  }
  for (int i = 0; i < 10 * points; ++i) center.push_back(at(radius, 0.1 * i));
  return {Walls(std::move(segments)), std::move(center)};
}

// Steers to the side with more clearance, measured 60 degrees left and right of straight ahead.
class CenterDriver : public Driver {
 public:
  explicit CenterDriver(double speed, double gain = 0.5) : speed_(speed), gain_(gain) {}

  StepResult step(const LaserScan& scan, const VehicleState& state, double) noexcept override {
    const double left = mean_range(scan, 0.6, 1.4), right = mean_range(scan, -1.4, -0.6);
    const double steering = gain_ * (left - right) / (left + right) * 2.0 - 0.05 * state.yaw_rate;
    return {{speed_, std::clamp(steering, -0.4, 0.4)}, Status::ok};
  }
  void reset() noexcept override { ++resets; }

  int resets = 0;

 private:
  static double mean_range(const LaserScan& scan, double from, double to) noexcept {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = scan.angle_min + scan.angle_increment * static_cast<double>(i);
      if (angle < from || angle > to || !std::isfinite(scan.ranges[i])) continue;
      sum += std::min(static_cast<double>(scan.ranges[i]), 4.0);
      ++count;
    }
    return count > 0 ? sum / count : 4.0;
  }

  double speed_, gain_;
};

// Always gives the same command.
class FixedDriver : public Driver {
 public:
  explicit FixedDriver(DriveCommand command) : command_(command) {}
  StepResult step(const LaserScan&, const VehicleState&, double) noexcept override { return {command_, Status::ok}; }
  void reset() noexcept override {}

 private:
  DriveCommand command_;
};

// No noise, no lost beams, no latency.
inline Car quiet(Car car) {
  car.sensors = {.speed_noise = 0.0, .yaw_rate_noise = 0.0, .steering_noise = 0.0};
  car.lidar.noise_sigma = car.lidar.dropout_rate = car.lidar.dropout_block_rate = 0.0;
  return car;
}

}  // namespace firstlap::sim::testing
