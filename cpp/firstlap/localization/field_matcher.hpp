// Scan-to-map matching: from a pose downhill in the likelihood field (Kohlbrecher et al. 2011).
#pragma once

#include <span>

#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/localization/params.hpp"
#include "firstlap/localization/particle_filter.hpp"

namespace firstlap::localization {

// The pose near `guess` (field's frame) that brings the beams onto walls.
Pose2 refined(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& guess,
              const RefineParams& params) noexcept;

// [1/m^2] inverse variance of `pose` along its heading, by the beams on walls; 0 where they tell nothing.
double forward_information(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose,
                           const RefineParams& params) noexcept;

// Share of the beams that end within `distance` [m] of a wall; 0 without beams.
double fit_of(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose, double distance) noexcept;

}  // namespace firstlap::localization
