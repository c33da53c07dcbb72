// Monte Carlo localization (Thrun, Burgard and Fox, chapter 8): a set of poses, moved by odometry and weighted by the
// scan. Poses are in the likelihood field's frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/rng.hpp"
#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/localization/motion.hpp"
#include "firstlap/localization/params.hpp"

namespace firstlap::localization {

// Uniform distribution for new particles: a disc of positions with radius [m], and headings within +-angle [rad].
struct Spread {
  Pose2 center{};
  double radius = 0.0, angle = 0.0;
  double share = 1.0;  // of all particles
};

struct Cluster {
  Pose2 pose{};                     // weighted mean of the particles around the best one
  double std = 0.0, std_yaw = 0.0;  // [m], [rad] standard deviation of those
  double share = 0.0;               // their share of the total weight
};

class ParticleFilter {
 public:
  // Keeps a reference to `field`.
  ParticleFilter(const LikelihoodField& field, const FilterParams& filter, const MotionParams& motion,
                 std::uint64_t seed);

  // Forgets everything and draws the maximum number of particles: most over the spread, the rest near its center.
  void scatter(const Spread& spread) noexcept;
  void move(double speed, double yaw_rate, double dt) noexcept;
  // The same motion for all particles, without noise.
  void shift(const Motion& motion) noexcept;
  // `searching` selects the wide likelihood.
  void weigh(std::span<const Beam> beams, bool searching) noexcept;
  [[nodiscard]] Cluster cluster() const noexcept;
  // Draws `count` particles: new ones in the spreads, by their shares, the rest by weight.
  void resample(std::size_t count, std::span<const Spread> fresh) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return particles_.size(); }

 private:
  struct Particle {
    double x = 0.0, y = 0.0, yaw = 0.0;
    double weight = 0.0;  // log weight after weigh(), then normalized
  };
  using Table = std::array<float, max_distance_mm + 1>;

  static Table table(double sigma, const FilterParams& params);
  Particle drawn(const Spread& spread) noexcept;
  void normalize() noexcept;
  [[nodiscard]] bool near(const Particle& p, const Pose2& center) const noexcept;
  [[nodiscard]] Cluster mean_around(const Pose2& center) const noexcept;

  const LikelihoodField* field_;
  FilterParams params_;
  MotionParams motion_;
  Rng rng_;
  Table narrow_, wide_;  // log likelihood of a return by its distance [mm]
  Buffer<Particle> particles_, drawn_;
};

}  // namespace firstlap::localization
