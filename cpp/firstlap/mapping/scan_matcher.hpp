// Point-to-line matching (Censi 2008) of a cloud with a reference of earlier clouds.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"
#include "firstlap/mapping/cloud.hpp"

namespace firstlap::mapping {

// Wall points with normals, in a grid for nearest-neighbor search. Points without a normal are left out.
class ReferenceCloud {
 public:
  explicit ReferenceCloud(std::span<const CloudPoint> points);

  // The point nearest to `at` within `reach` [m] whose normal is within acos(min_cosine) of `normal`; nullptr if there
  // is none.
  [[nodiscard]] const CloudPoint* nearest(Point2 at, Point2 normal, double reach, double min_cosine) const noexcept;
  [[nodiscard]] std::size_t size() const noexcept { return points_.size(); }

 private:
  bool bound(std::span<const CloudPoint> points) noexcept;
  [[nodiscard]] std::size_t cell_of(const CloudPoint& p) const noexcept;
  [[nodiscard]] int column(double x) const noexcept;
  [[nodiscard]] int row(double y) const noexcept;

  std::vector<CloudPoint> points_;  // sorted by cell
  std::vector<std::size_t> begin_;  // start of each cell, and the end of the last one
  double x_min_ = 0.0, y_min_ = 0.0;
  int columns_ = 0, rows_ = 0;
};

// Standard deviations of the guess, in its own frame; infinite without information.
struct Prior {
  double along, across, yaw;  // [m], [m], [rad]
};

struct Match {
  Pose2 pose{};                         // pose of the cloud's frame in the reference's
  std::array<double, 9> information{};  // row-major, of (x, y, yaw) in the cloud's frame, without the prior
  double fit = 0.0;                     // share of the points with a normal that lie on the reference
  double rms = 0.0;                     // [m] of those from their lines
  int iterations = 0;
};

// Matches from `guess`, with bounded work. Without correspondences the pose is the guess and `fit` is 0.
Match match(std::span<const CloudPoint> cloud, const ReferenceCloud& reference, const Pose2& guess, const Prior& prior,
            const MatchParams& params) noexcept;

}  // namespace firstlap::mapping
