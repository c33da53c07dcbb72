// Step 3: the track width. It is measured where both walls are visible, averaged over a window, and remembered where
// only one wall is visible.
#pragma once

#include <array>
#include <span>

#include "firstlap/perception/params.hpp"

namespace firstlap {

inline constexpr int max_width_window = 25;

// The width along one centerline, from the car outward.
class LocalWidth {
 public:
  LocalWidth(double remembered, const TrackWidthParams& params) noexcept
      : remembered_(remembered), window_(params.width_window), blend_(params.width_blend) {}

  // Adds a pair of walls `width` [m] apart.
  void observe(double width) noexcept;
  // Advances by `distance` [m] without a pair of walls.
  void miss(double distance) noexcept { since_pair_ += distance; }

  // Moving average [m] of the last pairs, blending into the remembered width with the distance since the last pair.
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

// The remembered width [m] after a scan with the pair widths `widths` [m] (reordered): a low-pass filter of their
// median with gain `gain`. Unchanged if there are fewer than `width_pairs`.
double remember_width(double remembered, std::span<double> widths, double gain,
                      const TrackWidthParams& params) noexcept;

}  // namespace firstlap
