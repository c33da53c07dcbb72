// Odometry: motion of base_link between two scans from measured speed and yaw rate.
#pragma once

#include <cmath>

#include "firstlap/common/types.hpp"

namespace firstlap::localization {

// In base_link before the motion.
struct Motion {
  double ahead = 0.0, left = 0.0, turn = 0.0;  // [m], [m], [rad]
};

// `slip` [s^2/m]: slip angle of the rear axle per lateral acceleration; the axle drifts outward in a curve.
inline Motion motion_of(double speed, double yaw_rate, double slip, double dt) noexcept {
  return {speed * dt, -slip * speed * yaw_rate * speed * dt, yaw_rate * dt};
}

// Along an arc, to second order.
inline Pose2 moved(const Pose2& pose, const Motion& motion) noexcept {
  const double middle = pose.yaw + 0.5 * motion.turn, c = std::cos(middle), s = std::sin(middle);
  return {pose.x + c * motion.ahead - s * motion.left, pose.y + s * motion.ahead + c * motion.left,
          pose.yaw + motion.turn};
}

}  // namespace firstlap::localization
