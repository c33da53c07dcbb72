#include "firstlap/localization/field_matcher.hpp"

#include <cmath>

#include "firstlap/common/geometry.hpp"
#include "firstlap/mapping/linear3.hpp"

namespace firstlap::localization {

Pose2 refined(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& guess,
              const RefineParams& params) noexcept {
  Pose2 pose = guess;
  const double prior = 1.0 / (params.prior * params.prior);
  for (int i = 0; i < params.iterations; ++i) {
    const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
    mapping::Normal3 normal;
    normal.add(1.0, 0.0, 0.0, pose.x - guess.x, prior);
    normal.add(0.0, 1.0, 0.0, pose.y - guess.y, prior);
    normal.add(0.0, 0.0, 1.0, wrap_angle(pose.yaw - guess.yaw), prior);
    for (const Beam& b : beams) {
      const auto bx = static_cast<double>(b.x), by = static_cast<double>(b.y);
      const double x = c * bx - s * by, y = s * bx + c * by;
      const auto [distance, dx, dy] = field.slope(pose.x + x, pose.y + y);
      if (distance > params.reach) continue;
      const double ratio = distance / params.sigma;
      normal.add(dx, dy, dy * x - dx * y, distance, 1.0 / (params.sigma * params.sigma * (1.0 + ratio * ratio)));
    }
    const auto step = normal.solve();
    pose = {pose.x + step[0], pose.y + step[1], wrap_angle(pose.yaw + step[2])};
    if (norm(step[0], step[1]) < 1e-4 && std::abs(step[2]) < 1e-4) break;
  }
  return pose;
}

double forward_information(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose,
                           const RefineParams& params) noexcept {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  mapping::Normal3 normal;  // order left, yaw, forward: the solution of the last unknown has the other two eliminated
  for (const Beam& b : beams) {
    const auto bx = static_cast<double>(b.x), by = static_cast<double>(b.y);
    const auto [distance, dx, dy] = field.slope(pose.x + c * bx - s * by, pose.y + s * bx + c * by);
    if (distance > params.sigma) continue;
    const double forward = c * dx + s * dy, left = c * dy - s * dx;
    normal.add(left, left * bx - forward * by, forward, 0.0, 1.0 / (params.sigma * params.sigma));
  }
  normal.b = {0.0, 0.0, 1.0};
  const double variance = normal.solve()[2];
  return variance > 0.0 ? 1.0 / variance : 0.0;
}

double fit_of(std::span<const Beam> beams, const LikelihoodField& field, const Pose2& pose, double distance) noexcept {
  if (beams.empty()) return 0.0;
  const auto c = static_cast<float>(std::cos(pose.yaw)), s = static_cast<float>(std::sin(pose.yaw));
  const auto x = static_cast<float>(pose.x), y = static_cast<float>(pose.y);
  const int limit = static_cast<int>(1000.0 * distance);
  int fitting = 0;
  for (const Beam& b : beams) fitting += field.distance_mm(x + c * b.x - s * b.y, y + s * b.x + c * b.y) <= limit;
  return static_cast<double>(fitting) / static_cast<double>(beams.size());
}

}  // namespace firstlap::localization
