// A drive along a track's centerline with exact or noisy scans, and the track's walls as a map.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "firstlap/common/geometry.hpp"
#include "firstlap/common/rng.hpp"
#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/mapping/cloud.hpp"
#include "firstlap/sim/lidar.hpp"
#include "firstlap/sim/progress.hpp"
#include "firstlap/sim/race.hpp"
#include "support/sim_scene.hpp"

namespace firstlap::testing {

inline sim::LidarParams quiet_lidar() {
  sim::LidarParams params;
  params.noise_sigma = params.dropout_rate = params.sweep_time = 0.0;
  return params;
}

// Scans of a stationary car.
class Camera {
 public:
  explicit Camera(const sim::Walls& walls, const sim::LidarParams& params = quiet_lidar(), std::uint64_t seed = 1)
      : lidar_(params, walls), rng_(seed), ranges_(static_cast<std::size_t>(params.beams)) {}

  LaserScan scan(const Pose2& base_link) {
    const double x = CarGeometry{}.laser_x;
    lidar_.scan({base_link.x + x * std::cos(base_link.yaw), base_link.y + x * std::sin(base_link.yaw), base_link.yaw},
                ranges_);
    lidar_.add_noise(ranges_, rng_);
    return lidar_.view(ranges_);
  }

 private:
  sim::Lidar lidar_;
  Rng rng_;
  std::vector<float> ranges_;
};

inline sim::Walls walls_of(const std::vector<Point2>& corners) {
  std::vector<sim::WallSegment> segments;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point2 a = corners[i], b = corners[(i + 1) % corners.size()];
    segments.push_back({a.x, a.y, b.x, b.y});
  }
  return sim::Walls(std::move(segments));
}

// A room with four different walls.
inline sim::Walls odd_room() {
  return walls_of({{-3, -2}, {4, -2.5}, {5, 1}, {2, 1.5}, {2.5, 4}, {-1, 3.5}, {-1.5, 2}, {-4, 2.2}});
}

inline std::vector<mapping::CloudPoint> cloud_of(mapping::CloudMaker& maker, const LaserScan& scan) {
  maker.make(scan, {});
  return {maker.cloud().begin(), maker.cloud().end()};
}

// The visible walls of a track on a grid with its lower left corner at `origin`.
inline localization::LikelihoodField field_of_track(const sim::Track& track, double resolution = 0.05) {
  std::vector<mapping::CloudPoint> points;
  for (const sim::WallSegment& s : track.walls.segments()) {
    const double length = norm(s.x2 - s.x1, s.y2 - s.y1);
    const int steps = static_cast<int>(length / (0.5 * resolution)) + 1;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      points.push_back({s.x1 + t * (s.x2 - s.x1), s.y1 + t * (s.y2 - s.y1), 0.0, 0.0});
    }
  }
  return localization::field_of(points, resolution);
}

// Along the centerline at constant speed.
class Drive {
 public:
  Drive(const sim::Track& track, double speed, std::uint64_t seed = 1)
      : progress_(track.centerline), camera_(track.walls, lidar(), seed), rng_(seed, 9), speed_(speed) {}

  static constexpr double dt = 0.025;

  Pose2 pose() const { return progress_.pose_at(s_); }
  void advance() { s_ += speed_ * dt; }
  LaserScan scan() { return camera_.scan(pose()); }
  VehicleState measured() {
    const Pose2 before = progress_.pose_at(s_ - speed_ * dt);
    return {speed_ + 0.03 * rng_.gaussian(), wrap_angle(pose().yaw - before.yaw) / dt + 0.02 * rng_.gaussian(), 0.0};
  }

 private:
  static sim::LidarParams lidar() {
    sim::LidarParams params;
    params.sweep_time = 0.0;
    return params;
  }

  sim::Progress progress_;
  Camera camera_;
  Rng rng_;
  double speed_, s_ = 1.0;
};

inline double distance(const Pose2& a, const Pose2& b) { return norm(a.x - b.x, a.y - b.y); }

}  // namespace firstlap::testing
