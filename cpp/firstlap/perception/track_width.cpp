#include "firstlap/perception/track_width.hpp"

#include <algorithm>

namespace firstlap {

void LocalWidth::observe(double width) noexcept {
  pairs_[static_cast<std::size_t>(next_)] = width;
  next_ = (next_ + 1) % window_;
  count_ = std::min(count_ + 1, window_);
  since_pair_ = 0.0;
}

double LocalWidth::value() const noexcept {
  if (count_ == 0) return remembered_;
  double sum = 0.0;
  for (int i = 0; i < count_; ++i) sum += pairs_[static_cast<std::size_t>(i)];
  const double mean = sum / static_cast<double>(count_);
  const double faded = std::min(1.0, since_pair_ / blend_);
  return mean + faded * (remembered_ - mean);
}

double remember_width(double remembered, std::span<double> widths, double gain,
                      const TrackWidthParams& params) noexcept {
  if (widths.size() < static_cast<std::size_t>(params.width_pairs)) return remembered;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  const double median = std::clamp(*middle, params.width_min, params.width_max);
  return remembered + gain * (median - remembered);
}

}  // namespace firstlap
