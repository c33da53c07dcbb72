// Random scans and states, plausible and implausible. FIRSTLAP_SEED and FIRSTLAP_COUNT override seed and count.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include "support/scene.hpp"

namespace firstlap::scene {

inline std::uint64_t seed_or(std::uint64_t standard) {
  const char* text = std::getenv("FIRSTLAP_SEED");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : standard;
}
inline int count_or(int standard) {
  const char* text = std::getenv("FIRSTLAP_COUNT");
  return text != nullptr ? std::atoi(text) : standard;
}
inline std::string how_to_repeat(std::uint64_t seed, int index) {
  return "reproduce with FIRSTLAP_SEED=" + std::to_string(seed) + " FIRSTLAP_COUNT=" + std::to_string(index + 1);
}

class RandomInputs {
 public:
  explicit RandomInputs(std::uint64_t seed) : generator_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(generator_); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(generator_); }
  bool chance(double p) { return uniform(0.0, 1.0) < p; }

  // A number as a faulty driver might send it.
  double absurd() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr double values[] = {
        std::numeric_limits<double>::quiet_NaN(), inf, -inf, 1e300, -1e300, 1e-300, 0.0, -1.0, 3.14, 100.0, -100.0, 1e6,
        std::numeric_limits<double>::denorm_min()};
    return values[static_cast<std::size_t>(integer(0, 12))];
  }

  // Walls of a random corridor, with or without noise, with beams lost or corrupted, and a valid or invalid header.
  Scan scan() {
    Scan scan;
    const int kinds[] = {0, 1, 2, 3, 5, 17, 100, 271, 541, 1081, 2048, 2049, 10000};
    const int size = chance(0.6) ? 271 : kinds[integer(0, 12)];
    scan.ranges.resize(static_cast<std::size_t>(size));
    scan.angle_increment = 1.5 * pi / std::max(1.0, static_cast<double>(size - 1));
    const double width_left = uniform(0.2, 3.0);
    const double width_right = uniform(0.2, 3.0);
    const double end = uniform(0.5, 40.0);
    const double yaw = uniform(-1.0, 1.0);
    const double nonsense = chance(0.5) ? 0.0 : uniform(0.0, 1.0);
    const bool pure_noise = chance(0.2);
    for (int i = 0; i < size; ++i) {
      const double angle = scan.angle_min + i * scan.angle_increment + yaw;
      const double sine = std::sin(angle);
      double r = sine > 0.0 ? width_left / std::max(sine, 1e-3) : width_right / std::max(-sine, 1e-3);
      r = std::min(r, end);
      if (pure_noise) r = uniform(-1.0, 35.0);
      if (nonsense > 0.0 && chance(nonsense)) r = absurd();
      scan.ranges[static_cast<std::size_t>(i)] = static_cast<float>(std::clamp(r, -3e38, 3e38));
      if (!std::isfinite(r)) scan.ranges[static_cast<std::size_t>(i)] = static_cast<float>(r);
    }
    if (chance(0.1)) scan.angle_min = absurd();
    if (chance(0.1)) scan.angle_increment = absurd();
    if (chance(0.1)) scan = scan.mirrored();
    if (chance(0.1)) scan.angle_increment = -scan.angle_increment;
    if (chance(0.05)) scan.range_min = absurd();
    if (chance(0.05)) scan.range_max = absurd();
    return scan;
  }

  VehicleState state() {
    VehicleState state{uniform(-1.0, 10.0), uniform(-6.0, 6.0), uniform(-0.5, 0.5)};
    if (chance(0.05)) state.speed = absurd();
    if (chance(0.05)) state.yaw_rate = absurd();
    if (chance(0.05)) state.steering_angle = absurd();
    return state;
  }

  double dt() { return chance(0.9) ? 0.025 : absurd(); }

 private:
  std::mt19937_64 generator_;
};

}  // namespace firstlap::scene
