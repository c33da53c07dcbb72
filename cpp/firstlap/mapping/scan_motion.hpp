// How the car moved between scans, from the scans alone: nothing that it measures about itself goes in.
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
  double begin = 0.0, end = 0.0;  // [s] of the two scans
  Pose2 motion{};                 // base_link at the end as seen from base_link at the begin
  double fit = 0.0;               // share of the points that lie on the walls of the scan before
  double along = 0.0;             // share of them that tells how far the car went; near 0 in a bare corridor
};

class ScanMotion {
 public:
  ScanMotion(const CloudParams& cloud, const MatchParams& match, const CarGeometry& car);

  // time: [s] of the scan's last beam. The motion since the scan that was kept before, once it is old enough to tell;
  // nothing until then, after a gap, and for a scan whose header makes no sense.
  std::optional<ScanStep> add(const LaserScan& scan, double time);

  // As if no scan had come.
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
  double heard_ = never;   // [s] of the last scan's last beam
  Pose2 velocity_{};       // [m/s], [rad/s] over the last step
  bool tracking_ = false;  // whether velocity_ is known
};

}  // namespace firstlap::mapping
