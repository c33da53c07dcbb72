// Scan-to-map matching: descent in the likelihood field from a start pose (Kohlbrecher et al. 2011).
#pragma once

#include <span>

#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/localization/params.hpp"
#include "firstlap/localization/particle_filter.hpp"

namespace firstlap::localization {

// The pose near `guess` (in the field's frame) for which the beams end on walls.
Pose2 refined(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& guess,
              const RefineParams& params) noexcept;

// [1/m^2] inverse variance of `pose` along its heading, from the beams that end on walls; 0 without information.
double forward_information(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose,
                           const RefineParams& params) noexcept;

// Share of the beams that end within `distance` [m] of a wall; 0 without beams.
double fit_of(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose, double distance) noexcept;

}  // namespace firstlap::localization
