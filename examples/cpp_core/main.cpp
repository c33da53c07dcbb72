// Use of the map-less driver in your own program: a scan and the measured state in, a command out. The scans here are
// those of a straight corridor, 2 m wide, with the car 0.3 m left of its center.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "firstlap/drivers/racer.hpp"

int main() {
  constexpr double half_width = 1.0, offset = 0.3, period = 0.025;
  // The paper's base setting. Throws std::invalid_argument for values out of range.
  firstlap::Racer racer{firstlap::Params{}};

  std::vector<float> ranges(1081);
  firstlap::LaserScan scan;
  scan.angle_min = -0.75 * std::numbers::pi;
  scan.angle_increment = 1.5 * std::numbers::pi / 1080.0;
  scan.range_min = 0.02;
  scan.range_max = 30.0;
  scan.ranges = ranges;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double side = std::sin(scan.angle_min + static_cast<double>(i) * scan.angle_increment);
    const double room = side > 0.0 ? half_width - offset : half_width + offset;
    ranges[i] = static_cast<float>(std::fmin(room / std::fmax(std::abs(side), 1e-6), scan.range_max));
  }

  firstlap::StepResult result;
  for (int step = 0; step < 40; ++step) {
    const firstlap::VehicleState state{result.command.speed, 0.0,
                                       0.0};  // speed [m/s], yaw rate [rad/s], steering [rad]
    result = racer.step(scan, state, period);
  }
  std::printf("%s: %.2f m/s, %.1f degrees to the %s\n", firstlap::to_string(result.status), result.command.speed,
              std::abs(result.command.steering_angle) * 180.0 / std::numbers::pi,
              result.command.steering_angle < 0.0 ? "right" : "left");
  return result.status == firstlap::Status::ok && result.command.steering_angle < 0.0 ? 0 : 1;
}
