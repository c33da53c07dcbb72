// Point-to-line matching (Censi 2008): where a cloud lies in a reference made of earlier ones.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"
#include "firstlap/mapping/cloud.hpp"

namespace firstlap::mapping {

// Wall points with normals, found by place. Points without a normal are left out.
class ReferenceCloud {
 public:
  explicit ReferenceCloud(std::span<const CloudPoint> points);

  // The nearest point within `reach` [m] whose normal is within acos(min_cosine) of (nx, ny), or none.
  [[nodiscard]] const CloudPoint* nearest(double x, double y, double nx, double ny, double reach,
                                          double min_cosine) const noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }

 private:
  [[nodiscard]] int column(double x) const noexcept;
  [[nodiscard]] int row(double y) const noexcept;

  std::vector<CloudPoint> points_;  // sorted by cell
  std::vector<std::size_t> begin_;  // of each cell, and the end of the last
  double x_min_ = 0.0, y_min_ = 0.0;
  int columns_ = 0, rows_ = 0;
};

// What odometry says of the pose: standard deviations in the guess's frame; infinite where it says nothing.
struct Prior {
  double along, across, yaw;  // [m], [m], [rad]
};

struct Match {
  Pose2 pose{};                         // of the cloud's frame in the reference's
  std::array<double, 9> information{};  // row by row, of (x, y, yaw) in the cloud's frame; the prior left out
  double fit = 0.0;                     // share of the points with a normal that lie on the reference
  double rms = 0.0;                     // [m] of those from their lines
  int iterations = 0;
};

// From `guess`; bounded work. With no partners the pose is the guess and `fit` 0.
Match match(std::span<const CloudPoint> cloud, const ReferenceCloud& reference, const Pose2& guess, const Prior& prior,
            const MatchParams& params) noexcept;

}  // namespace firstlap::mapping
