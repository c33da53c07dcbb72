// A seeded generator that gives the same numbers with every standard library: xoshiro256++ (Blackman and Vigna, 2019),
// seeded by splitmix64; normal deviates by the ziggurat of Marsaglia and Tsang (2000) in Doornik's form (128 layers).
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace firstlap {

class Rng {
 public:
  // `stream` selects one of several independent sequences per seed, for example one per sensor.
  explicit Rng(std::uint64_t seed, std::uint64_t stream = 0) noexcept;

  std::uint64_t next() noexcept {
    const std::uint64_t result = std::rotl(word_[0] + word_[3], 23) + word_[0];
    const std::uint64_t shifted = word_[1] << 17;
    word_[2] ^= word_[0];
    word_[3] ^= word_[1];
    word_[1] ^= word_[2];
    word_[0] ^= word_[3];
    word_[2] ^= shifted;
    word_[3] = std::rotl(word_[3], 45);
    return result;
  }

  // Uniform in [0, 1), 53 bits.
  double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }

  // Normal with mean 0 and standard deviation 1.
  double gaussian() noexcept;

 private:
  double gaussian_tail(bool negative) noexcept;

  std::array<std::uint64_t, 4> word_{};
};

}  // namespace firstlap
