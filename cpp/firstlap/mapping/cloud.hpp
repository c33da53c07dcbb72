// A scan as a cloud of evenly spaced wall points with normals, in base_link at the end of the sweep.
#pragma once

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/mapping/params.hpp"
#include "firstlap/perception/scan.hpp"

namespace firstlap::mapping {

struct CloudPoint {
  double x = 0.0, y = 0.0;    // [m]
  double nx = 0.0, ny = 0.0;  // unit normal of the wall, toward the LiDAR; 0, 0 if unknown
};

class CloudMaker {
 public:
  CloudMaker(const CloudParams& params, const CarGeometry& car);

  // Returns false if the scan's header is invalid; then points and cloud are empty. `period`: [s] between scans, 0 if
  // unknown.
  bool make(const LaserScan& scan, const VehicleState& state, double period = 0.0) noexcept;

  [[nodiscard]] const Buffer<ScanPoint>& points() const noexcept { return points_; }  // all valid returns
  [[nodiscard]] const Buffer<CloudPoint>& cloud() const noexcept { return cloud_; }   // evenly spaced

 private:
  struct Group {
    double x = 0.0, y = 0.0;
    bool opens = false;  // first point of a wall
  };

  bool joined(const ScanPoint& a, const ScanPoint& b) const noexcept;
  void group_points() noexcept;
  void add_normal(std::size_t i) noexcept;
  bool fit_normal(std::size_t first, std::size_t last, CloudPoint& point) const noexcept;

  CloudParams params_;
  CarGeometry car_;
  ScanParams scan_;
  BeamTable table_;
  Buffer<ScanPoint> points_;
  Buffer<Group> groups_;
  Buffer<CloudPoint> cloud_;
};

}  // namespace firstlap::mapping
