// A Gaussian distribution of N states and the two steps of a Kalman filter. Measurements are scalar, so that no matrix
// is inverted. The covariance is corrected in Joseph form, a sum of two positive semi-definite matrices, so that it
// stays positive semi-definite in spite of rounding. Fixed size, no allocation.
#pragma once

#include <array>
#include <cstddef>

namespace firstlap {

template <std::size_t N>
struct Gaussian {
  using Vector = std::array<double, N>;
  using Matrix = std::array<Vector, N>;

  Vector mean{};
  Matrix covariance{};

  static constexpr Matrix identity() noexcept {
    Matrix result{};
    for (std::size_t i = 0; i < N; ++i) result[i][i] = 1.0;
    return result;
  }

  // P <- F P F' + diag(noise). The caller predicts the mean; `transition` is the Jacobian of that prediction.
  void propagate(const Matrix& transition, const Vector& noise) noexcept {
    covariance = congruent(transition, covariance);
    for (std::size_t i = 0; i < N; ++i) covariance[i][i] += noise[i];
  }

  // Innovation variance of a measurement with the row `row` of the measurement matrix and the noise `variance`.
  [[nodiscard]] double innovation_variance(const Vector& row, double variance) const noexcept {
    return dot(row, times(covariance, row)) + variance;
  }

  // `innovation`: measured minus predicted. P <- (I - K h') P (I - K h')' + R K K'.
  void correct(const Vector& row, double innovation, double variance) noexcept {
    const double total = innovation_variance(row, variance);
    Vector gain = times(covariance, row);
    for (double& each : gain) each /= total;
    Matrix left = identity();
    for (std::size_t i = 0; i < N; ++i) {
      mean[i] += gain[i] * innovation;
      for (std::size_t j = 0; j < N; ++j) left[i][j] -= gain[i] * row[j];
    }
    covariance = congruent(left, covariance);
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) covariance[i][j] += variance * gain[i] * gain[j];
    }
  }

  // Scales the standard deviation of state `i` by `factor`.
  void scale(std::size_t i, double factor) noexcept {
    for (std::size_t j = 0; j < N; ++j) {
      covariance[i][j] *= factor;
      covariance[j][i] *= factor;
    }
  }

 private:
  static double dot(const Vector& a, const Vector& b) noexcept {
    double sum = 0.0;
    for (std::size_t i = 0; i < N; ++i) sum += a[i] * b[i];
    return sum;
  }

  static Vector times(const Matrix& matrix, const Vector& vector) noexcept {
    Vector result{};
    for (std::size_t i = 0; i < N; ++i) result[i] = dot(matrix[i], vector);
    return result;
  }

  // A P A' of a symmetric P; the result is exactly symmetric.
  static Matrix congruent(const Matrix& a, const Matrix& p) noexcept {
    Matrix result{};
    for (std::size_t i = 0; i < N; ++i) {
      const Vector row = times(p, a[i]);
      for (std::size_t j = 0; j <= i; ++j) result[i][j] = result[j][i] = dot(row, a[j]);
    }
    return result;
  }
};

}  // namespace firstlap
