// Normal equations of a pose, with three unknowns.
#pragma once

#include <array>
#include <cmath>

namespace firstlap::mapping {

// A symmetric 3 x 3 system H d = b, accumulated from rows J with residual e and weight w: H += w J J', b -= w e J.
struct Normal3 {
  std::array<double, 9> h{};
  std::array<double, 3> b{};

  void add(double j0, double j1, double j2, double e, double w) noexcept {
    const std::array<double, 3> j{j0, j1, j2};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) h[3 * r + c] += w * j[r] * j[c];
      b[r] -= w * e * j[r];
    }
  }

  // Cholesky decomposition; 0 if H is not positive definite.
  [[nodiscard]] std::array<double, 3> solve() const noexcept {
    const double l00 = std::sqrt(h[0]);
    if (!(h[0] > 1e-12)) return {};
    const double l10 = h[3] / l00, l20 = h[6] / l00, d1 = h[4] - l10 * l10;
    if (!(d1 > 1e-12)) return {};
    const double l11 = std::sqrt(d1), l21 = (h[7] - l20 * l10) / l11, d2 = h[8] - l20 * l20 - l21 * l21;
    if (!(d2 > 1e-12)) return {};
    const double l22 = std::sqrt(d2);
    const double y0 = b[0] / l00, y1 = (b[1] - l10 * y0) / l11, y2 = (b[2] - l20 * y0 - l21 * y1) / l22;
    const double x2 = y2 / l22, x1 = (y1 - l21 * x2) / l11, x0 = (y0 - l10 * x1 - l20 * x2) / l00;
    return {x0, x1, x2};
  }
};

}  // namespace firstlap::mapping
