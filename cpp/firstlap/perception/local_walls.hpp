// What is known of the walls around the car: evenly spaced samples per side, of this scan and, where a
// wall has just gone out of sight, of the scans before.
#pragma once

#include <tuple>
#include <vector>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/types.hpp"

namespace firstlap {

inline constexpr std::size_t max_samples = 1024;  // of one side

// The line of sight past the end of a wall: up to it everything is free, behind it nothing is known.
struct Sight {
  float x = 0.0F;  // unit vector away from the laser
  float y = 0.0F;
  float shadow = 0.0F;  // +1: what is hidden lies to the left of it, -1: to the right, 0: there is no such line
  bool way_on = false;  // between it and the other wall lies the way on
};

// Coordinates stand apart so that the search for the nearest sample runs in vector instructions.
struct WallSide {
  WallSide() : x(max_samples), y(max_samples), outward(max_samples), sight(max_samples), age(max_samples) {}

  Buffer<float> x;         // [m] base_link
  Buffer<float> y;         // [m] base_link
  Buffer<Point2> outward;  // unit vector along the wall out of sight, at a visible end; else zero
  Buffer<Sight> sight;     // past a visible end
  Buffer<float> age;       // [s] since it was seen; 0: in this scan
  std::size_t seen = 0;    // the first samples are of this scan, the others remembered

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
        Column{"outward", &C::outward, "", "unit vector along the wall out of sight, at a visible end; else zero"},
        Column{"age", &C::age, "s", "since each sample was seen; 0: in this scan"},
    };
  }
};

struct Nearest {
  std::size_t index = 0;
  double distance = 0.0;  // [m]; infinite where the side is empty
};

Nearest nearest_sample(const WallSide& side, double px, double py) noexcept;

// Asks the first `count` samples of a side for one point after the other along a wall: the answer is most
// often next to the last one.
class WallSearch {
 public:
  WallSearch(const WallSide& side, std::size_t count) noexcept : side_(side), count_(count) {}

  Nearest nearest(double x, double y) noexcept;

  // The nearest of the samples on from the last answer, downhill along the wall; of all where that is farther than
  // `reach` [m]. Another one where the wall comes back on itself.
  Nearest nearest_onwards(double x, double y, double reach) noexcept;

  // To the nearest sample [m], or to one that is nearer than `enough` [m].
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

// Where the car has been, in today's base_link, oldest first.
struct TrailPoint {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;
  double age = 0.0;  // [s]
};

// Expresses every sample in the base_link that `motion` (in the old base_link) leads to, `dt` later.
void move_walls(const Pose2& motion, double dt, LocalWalls& walls) noexcept;

}  // namespace firstlap
