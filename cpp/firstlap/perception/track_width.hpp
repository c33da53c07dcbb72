// Step 3: the track width, point by point where both walls are seen, averaged over a window, and
// remembered where one of them is not.
#pragma once

#include <array>
#include <span>

#include "firstlap/perception/params.hpp"

namespace firstlap {

inline constexpr int max_width_window = 25;

// The width along one line, from the car outwards.
class LocalWidth {
 public:
  LocalWidth(double remembered, const TrackWidthParams& params) noexcept
      : remembered_(remembered), window_(params.width_window), blend_(params.width_blend) {}

  // A pair of walls was met `width` [m] apart.
  void observe(double width) noexcept;
  // The line went on by `distance` [m] without a pair.
  void miss(double distance) noexcept { since_pair_ += distance; }

  // Moving average of the last pairs, fading to the remembered width with the way since the last one.
  [[nodiscard]] double value() const noexcept;

 private:
  std::array<double, max_width_window> pairs_{};
  int next_ = 0;
  int count_ = 0;
  double since_pair_ = 0.0;
  double remembered_;
  int window_;
  double blend_;
};

// The remembered width after a scan whose pairs were `widths` [m] (reordered): `gain` of their median goes
// in. Fewer pairs than `width_pairs` are not trusted.
double remember_width(double remembered, std::span<double> widths, double gain,
                      const TrackWidthParams& params) noexcept;

}  // namespace firstlap
