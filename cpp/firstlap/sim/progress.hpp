// Progress along a closed centerline: arc length s, lateral offset (left positive) and distance traveled of a moving
// point. The search is limited to the neighborhood of the previous position, so that a neighboring part of the track is
// never matched.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "firstlap/common/types.hpp"

namespace firstlap::sim {

struct Projection {
  double s = 0.0;       // [m] in [0, length)
  double offset = 0.0;  // [m] left positive
};

class Progress {
 public:
  // `centerline`: closed, in the direction of travel, first point not repeated. Throws std::invalid_argument for fewer
  // than three points, a point that is not finite, or length 0. Duplicate points are dropped.
  explicit Progress(std::span<const Point2> centerline);

  double length() const noexcept { return length_; }  // [m]
  Pose2 pose_at(double s) const noexcept;             // any s [m]; heading along the centerline
  Projection locate(Point2 point) const noexcept;     // nearest point of the whole centerline

  // Nearest point within 2 m of arc length of `s` [m] in [0, length): one `update` of a point that was last at `s`.
  Projection locate_near(double s, Point2 point) const noexcept;

  void reset(Point2 point) noexcept;   // nearest point of the whole centerline; sets traveled to 0
  void update(Point2 point) noexcept;  // nearest point within 2 m of arc length of the last one

  double s() const noexcept { return place_.s; }                    // [m] in [0, length)
  double lateral_offset() const noexcept { return place_.offset; }  // [m] left positive
  double traveled() const noexcept { return traveled_; }            // [m] since reset, over all laps, signed

 private:
  struct Candidate {
    std::size_t index = 0;
    double s = 0.0, offset = 0.0, distance = 0.0;
  };

  Candidate project(std::size_t index, Point2 point) const noexcept;
  Candidate nearest_around(std::size_t index, double s, Point2 point) const noexcept;
  std::size_t index_at(double s) const noexcept;  // of the last point at or before `s`
  void accept(const Candidate& best) noexcept;
  std::size_t next(std::size_t i) const noexcept { return i + 1 == points_.size() ? 0 : i + 1; }
  std::size_t previous(std::size_t i) const noexcept { return i == 0 ? points_.size() - 1 : i - 1; }

  std::vector<Point2> points_;
  std::vector<double> s_;  // arc length at each point, and the total length at the end
  double length_ = 0.0;
  Projection place_{};
  std::size_t index_ = 0;
  double traveled_ = 0.0;
};

}  // namespace firstlap::sim
