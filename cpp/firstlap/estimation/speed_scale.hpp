// Estimation: how far the car's speed constant is wrong. The walls tell how fast they really go by; what was commanded
// lately tells whether the car then drives what it is told. Both are learned slowly, believed only where they differ
// clearly from 1, and bounded.
#pragma once

#include "firstlap/estimation/params.hpp"
#include "firstlap/perception/local_walls.hpp"
#include "firstlap/perception/section_samples.hpp"

namespace firstlap {

// How much further the car came than it was taken to have come, by the walls of two scans.
struct MotionError {
  double forward = 0.0;      // [m]
  double information = 0.0;  // [1/m^2] inverse variance; 0 where the walls tell nothing
};

// `before`: walls of the last scan, moved by odometry into today's base_link. `now`: today's samples, with their votes.
// `moved`: [m] how far they were moved. A point-to-line fit of the forward, sideways and yaw error that are left.
MotionError forward_error(const LocalWalls& before, const Buffer<SectionSample>& now, double moved,
                          const SpeedScaleParams& params) noexcept;

// What lasts of it from one scan to the next.
struct SpeedScale {
  static constexpr double unknown = 0.01;  // variance of the ratio of a car that nothing is known of
  static constexpr double belief = 4.0;    // [m^2/s] of driving by which a car is believed at first: 1 s at 2 m/s

  double ratio = 1.0;                // true speed per measured
  double variance = unknown;         // of it
  double expected = 0.0;             // [m/s] what the car should measure by the commands of late
  double commanded_square = belief;  // integral of expected^2 over time, forgotten slowly
  double commanded_driven = belief;  // integral of expected times measured
};

// A scan later: the car was taken to have moved `moved` [m] where it measured `measured` [m].
void learn_from_walls(const MotionError& error, double moved, double measured, double dt,
                      const SpeedScaleParams& params, SpeedScale& scale) noexcept;

// `command` [m/s] was in effect over the last `dt` [s], at whose end the car measured `measured` [m/s].
void learn_from_command(double command, double measured, double dt, const SpeedScaleParams& params,
                        SpeedScale& scale) noexcept;

// To multiply a measured speed by: exactly 1 where nothing speaks clearly against it.
double true_per_measured(const SpeedScale& scale, const SpeedScaleParams& params) noexcept;

// To divide a speed command by: above 1 where the car drives faster than it is told, never below.
double true_per_commanded(const SpeedScale& scale, const SpeedScaleParams& params) noexcept;

}  // namespace firstlap
