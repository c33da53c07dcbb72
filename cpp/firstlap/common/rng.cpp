#include "firstlap/common/rng.hpp"

#include <cmath>
#include <cstddef>

namespace firstlap {
namespace {

constexpr std::size_t layers = 128;
constexpr double tail_start = 3.442619855899;
constexpr double layer_area = 9.91256303526217e-3;

double density(double x) { return std::exp(-0.5 * x * x); }

// Right edges of the layers, and the share of each layer that lies entirely under the density.
struct Ziggurat {
  std::array<double, layers + 1> edge{};
  std::array<double, layers> sure{};

  Ziggurat() {
    edge[0] = layer_area / density(tail_start);
    edge[1] = tail_start;
    for (std::size_t i = 2; i < layers; ++i) {
      edge[i] = std::sqrt(-2.0 * std::log(layer_area / edge[i - 1] + density(edge[i - 1])));
    }
    for (std::size_t i = 0; i < layers; ++i) sure[i] = edge[i + 1] / edge[i];
  }
};

const Ziggurat ziggurat;

std::uint64_t splitmix64(std::uint64_t& state) noexcept {
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31);
}

}  // namespace

Rng::Rng(std::uint64_t seed, std::uint64_t stream) noexcept {
  std::uint64_t stream_state = stream;
  std::uint64_t state = seed ^ splitmix64(stream_state);
  for (std::uint64_t& word : word_) word = splitmix64(state);
}

double Rng::gaussian() noexcept {
  for (;;) {
    const std::uint64_t bits = next();
    const std::size_t layer = bits % layers;
    const double u = static_cast<double>(bits >> 11) * 0x1p-52 - 1.0;
    if (std::abs(u) < ziggurat.sure[layer]) return u * ziggurat.edge[layer];
    if (layer == 0) return gaussian_tail(u < 0.0);
    const double x = u * ziggurat.edge[layer];
    const double low = density(ziggurat.edge[layer]);
    const double high = density(ziggurat.edge[layer + 1]);
    if (low + uniform() * (high - low) < density(x)) return x;
  }
}

double Rng::gaussian_tail(bool negative) noexcept {
  for (;;) {
    const double x = std::log(1.0 - uniform()) / tail_start;
    const double y = std::log(1.0 - uniform());
    if (-2.0 * y >= x * x) return negative ? x - tail_start : tail_start - x;
  }
}

}  // namespace firstlap
