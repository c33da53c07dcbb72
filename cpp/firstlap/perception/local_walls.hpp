// The known walls around the car: evenly spaced samples of each side, from this scan and, where occluded, carried over
// from earlier scans.
#pragma once

#include <tuple>
#include <vector>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap {

inline constexpr std::size_t max_samples = 1024;  // per side

// The line of sight past a visible end of a wall. It separates free space from the occluded area behind the end.
struct Sight {
  float x = 0.0F;  // unit vector away from the LiDAR
  float y = 0.0F;
  float shadow = 0.0F;           // +1: the occluded area is to its left, -1: to its right, 0: no line of sight
  bool track_continues = false;  // the track continues between it and the other wall
};

// Separate coordinate arrays, so that the nearest-sample search is vectorized.
struct WallSide {
  WallSide() : x(max_samples), y(max_samples), outward(max_samples), sight(max_samples), age(max_samples) {}

  Buffer<float> x;         // [m] base_link
  Buffer<float> y;         // [m] base_link
  Buffer<Point2> outward;  // at a visible end, unit vector along the wall into the occluded area; else zero
  Buffer<Sight> sight;     // past a visible end
  Buffer<float> age;       // [s] since the sample was measured; 0: in this scan
  std::size_t seen = 0;    // number of samples from this scan; the others are carried over

  [[nodiscard]] std::size_t size() const noexcept { return x.size(); }
  [[nodiscard]] Point2 at(std::size_t i) const noexcept {
    return {static_cast<double>(x[i]), static_cast<double>(y[i])};
  }
  void clear() noexcept;
  void push(double px, double py, Point2 out, float seen_before, Sight past = {}) noexcept;
  [[nodiscard]] std::vector<Point2> points() const;  // allocates

  static constexpr auto columns() {
    using C = WallSide;
    return std::tuple{
        Column{"points", &C::points, "m", "samples of the wall"},
        Column{"outward", &C::outward, "",
               "at a visible end, unit vector along the wall into the occluded area; else zero"},
        Column{"age", &C::age, "s", "since each sample was measured; 0: in this scan"},
    };
  }
};

struct Nearest {
  std::size_t index = 0;
  double distance = 0.0;  // [m]; infinite for a side without samples
};

Nearest nearest_sample(const WallSide& side, double px, double py) noexcept;

// Nearest-sample search for a sequence of points along a wall, among the first `count` samples of a side. The result is
// usually close to the previous one, where the search starts.
class WallSearch {
 public:
  WallSearch(const WallSide& side, std::size_t count) noexcept : side_(side), count_(count) {}

  Nearest nearest(double x, double y) noexcept;

  // Local search downhill along the wall from the previous result; among all samples if that ends farther away than
  // `reach` [m]. Not always the nearest sample where the wall turns back.
  Nearest nearest_onwards(double x, double y, double reach) noexcept;

  // Distance [m] to the nearest sample, or to any sample closer than `enough` [m].
  double distance(double x, double y, double enough) noexcept;

 private:
  const WallSide& side_;
  std::size_t count_;
  std::size_t last_ = 0;
};

struct LocalWalls {
  WallSide left;
  WallSide right;
};

// A past pose of the car in the current base_link. Trails are ordered oldest first.
struct TrailPoint {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  double age = 0.0;  // [s]
};

// Transforms every sample into the base_link reached by `motion` (a pose in the old base_link), `dt` [s] later.
void move_walls(const Pose2& motion, double dt, LocalWalls& walls) noexcept;

}  // namespace firstlap
