// Motion of the car between scans, from the scans alone, without odometry.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/mapping/cloud.hpp"
#include "firstlap/mapping/scan_matcher.hpp"
#include "firstlap/perception/scan_period.hpp"

namespace firstlap::mapping {

struct ScanStep {
  double begin = 0.0, end = 0.0;  // [s] times of the two scans
  Pose2 motion{};                 // base_link at the end, in base_link at the beginning
  double fit = 0.0;               // share of the points that lie on the walls of the earlier scan
  double along = 0.0;  // share of the points that constrain the forward motion; near 0 in a featureless corridor
};

class ScanMotion {
 public:
  ScanMotion(const CloudParams& cloud, const MatchParams& match, const CarGeometry& car);

  // `time`: [s] of the scan's last beam. Returns the motion since the reference scan once that is old enough; nothing
  // before that, after a gap, or for a scan with an invalid header.
  std::optional<ScanStep> add(const LaserScan& scan, double time);

  // Clears all earlier scans.
  void forget() noexcept {
    kept_.reset();
    tracking_ = false;
    period_ = {};
    heard_ = never;
  }

 private:
  static constexpr double never = -std::numeric_limits<double>::infinity();

  struct Kept {
    double time = 0.0;
    ReferenceCloud cloud;
  };

  [[nodiscard]] Match best_match(double elapsed) const noexcept;
  void keep(double time);

  CloudMaker maker_;
  MatchParams match_;
  std::optional<Kept> kept_;
  ScanPeriod period_{};
  double heard_ = never;   // [s] time of the last scan's last beam
  Pose2 velocity_{};       // [m/s], [rad/s] mean over the last step
  bool tracking_ = false;  // whether velocity_ is known
};

}  // namespace firstlap::mapping
