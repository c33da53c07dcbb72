// Estimates the scale error of the car's speeds. Wall samples of successive scans give the true motion; the measured
// response to earlier commands gives the scale of commands. Both scales are filtered, corrected only where they differ
// significantly from 1, and bounded.
#pragma once

#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/estimation/params.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/section_samples.hpp"

namespace firstlap {

// Error of the assumed motion between two scans, from the walls.
struct MotionError {
  double forward = 0.0;      // [m] true minus assumed forward motion
  double information = 0.0;  // [1/m^2] inverse variance; 0 if the walls give no information
};

// Point-to-line fit of the remaining forward, lateral and yaw error. `before`: walls of the previous scan, moved by
// odometry into the current base_link, by `moved` [m]. `now`: labeled samples of the current scan.
MotionError forward_error(const LocalWalls& before, const Buffer<SectionSample>& now, double moved,
                          const SpeedScaleParams& params) noexcept;

// State of the estimator between scans.
struct SpeedScale {
  static constexpr double unknown = 0.01;  // variance of the ratio before any measurement
  static constexpr double belief = 4.0;    // [m^2/s] prior weight of commands: 1 s of driving at 2 m/s

  double ratio = 1.0;                // true speed per measured speed
  double variance = unknown;         // of the ratio
  double expected = 0.0;             // [m/s] speed that the car should measure after the latest commands
  double commanded_square = belief;  // integral of expected^2 over time, with exponential forgetting
  double commanded_driven = belief;  // integral of expected times measured, likewise
};

// Forward motion between two scans.
struct ForwardMotion {
  double assumed = 0.0;   // [m] with the scale so far
  double measured = 0.0;  // [m] by odometry
  double dt = 0.0;        // [s]
};

// Update after a scan.
void learn_from_walls(const MotionError& error, const ForwardMotion& motion, const SpeedScaleParams& params,
                      SpeedScale& scale) noexcept;

// Updates the speed expected after `dt` [s] with `command` [m/s] in effect.
void expect_speed(double command, double dt, const CarDynamics& car, SpeedScale& scale) noexcept;

// Update with `measured` [m/s], `dt` [s] after the last one, while the car was expected to follow its commands.
void learn_from_command(double measured, double dt, const SpeedScaleParams& params, SpeedScale& scale) noexcept;

// Factor for measured speeds; exactly 1 without a significant error.
double measured_speed_scale(const SpeedScale& scale, const SpeedScaleParams& params) noexcept;

// Divisor for speed commands: above 1 if the car drives faster than commanded, never below 1.
double command_speed_scale(const SpeedScale& scale, const SpeedScaleParams& params) noexcept;

}  // namespace firstlap
