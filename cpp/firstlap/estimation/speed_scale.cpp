#include "firstlap/estimation/speed_scale.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "firstlap/common/geometry.hpp"

namespace firstlap {
namespace {

constexpr double sample_sigma = 0.01;   // [m] standard deviation of a wall sample, normal to the wall
constexpr double lateral_sigma = 0.03;  // [m] lateral odometry error between two scans
constexpr double yaw_sigma = 0.02;      // [rad] heading error of the odometry between two scans
constexpr double same_wall = 0.3;       // [m] a sample within this distance of an earlier one belongs to the same wall
constexpr double neighbor = 0.4;        // [m] maximum spacing of samples on one wall
constexpr double straight = 0.9;        // cosine; the wall direction is undefined where it turns by more
constexpr double believable = 0.05;     // [m] maximum distance from the wall that a wrong speed does not explain
constexpr double min_fit = 1e-6;        // minimum sum of squared normals: below, no wall faces the direction of travel
constexpr std::size_t stride = 3;       // every so many samples one is used
constexpr double chance = 2.0;          // standard deviations within which an error may be noise
constexpr double ramp = 0.01;           // width of the blend from no correction to full correction
constexpr double min_motion = 0.01;     // [m] minimum motion that gives a measurement of the scale
constexpr double min_driven = 1e-6;     // [m^2/s] minimum of driving that gives a command scale
constexpr double response_slack = 0.2;  // [m/s] deviation from the command that a wrong scale does not explain

double dot(Point2 a, Point2 b) noexcept { return a.x * b.x + a.y * b.y; }

// The wall's direction at sample `i` as a unit vector; zero where it is undefined.
Point2 direction(const WallSide& side, std::size_t i) noexcept {
  if (i == 0 || i + 1 >= side.seen) return {};
  const Point2 a = side.at(i - 1);
  const Point2 b = side.at(i);
  const Point2 c = side.at(i + 1);
  const Point2 first{b.x - a.x, b.y - a.y};
  const Point2 second{c.x - b.x, c.y - b.y};
  const double first_square = dot(first, first);
  const double second_square = dot(second, second);
  if (std::max(first_square, second_square) > neighbor * neighbor) return {};
  const double along = dot(first, second);
  if (along <= 0.0 || along * along < straight * straight * first_square * second_square) return {};
  const double scale = 1.0 / norm(c.x - a.x, c.y - a.y);
  return {scale * (c.x - a.x), scale * (c.y - a.y)};
}

// Normal equations for the forward, lateral and yaw error.
struct Fit {
  std::array<double, 6> a{};  // upper triangle: ff, fl, fy, ll, ly, yy
  std::array<double, 3> b{};

  void add(const std::array<double, 3>& row, double residual) noexcept {
    a[0] += row[0] * row[0];
    a[1] += row[0] * row[1];
    a[2] += row[0] * row[2];
    a[3] += row[1] * row[1];
    a[4] += row[1] * row[2];
    a[5] += row[2] * row[2];
    for (std::size_t k = 0; k < 3; ++k) b[k] += row[k] * residual;
  }

  // The forward error, with the other two eliminated.
  [[nodiscard]] MotionError solve() const noexcept {
    const double ll = a[3] + square(sample_sigma / lateral_sigma);
    const double yy = a[5] + square(sample_sigma / yaw_sigma);
    const double determinant = ll * yy - a[4] * a[4];
    const double l = (a[1] * yy - a[2] * a[4]) / determinant;
    const double y = (a[2] * ll - a[1] * a[4]) / determinant;
    const double left = a[0] - a[1] * l - a[2] * y;
    if (!(left > min_fit)) return {};
    return {(b[0] - b[1] * l - b[2] * y) / left, left / square(sample_sigma)};
  }

  static double square(double value) noexcept { return value * value; }
};

// The part of `error` to correct: none within noise and tolerance, then blending to all of it.
double correction(double error, double tolerance, const SpeedScale& scale, const SpeedScaleParams& params) noexcept {
  const double bounded = std::clamp(error, -params.scale_limit, params.scale_limit);
  const double clear = (std::abs(bounded) - tolerance - chance * std::sqrt(scale.variance)) / ramp;
  return bounded * std::clamp(clear, 0.0, 1.0);
}

}  // namespace

MotionError forward_error(const LocalWalls& before, const Buffer<SectionSample>& now, double moved,
                          const SpeedScaleParams& params) noexcept {
  WallSearch left(before.left, before.left.seen);
  WallSearch right(before.right, before.right.seen);
  Fit fit;
  for (std::size_t k = 0; k < now.size(); k += stride) {
    const SectionSample& sample = now[k];
    if (sample.vote == 0) continue;
    const WallSide& side = sample.vote > 0 ? before.left : before.right;
    const Nearest nearest = (sample.vote > 0 ? left : right).nearest_onwards(sample.x, sample.y, same_wall);
    if (nearest.distance > same_wall) continue;
    const Point2 t = direction(side, nearest.index);
    const Point2 wall = side.at(nearest.index);
    const double nx = -t.y;
    const double ny = t.x;
    const double off = nx * (sample.x - wall.x) + ny * (sample.y - wall.y);
    if (std::abs(off) > believable + params.scale_limit * std::abs(moved * nx)) continue;
    fit.add({-nx, -ny, nx * sample.y - ny * sample.x}, off);
  }
  return fit.solve();
}

void learn_from_walls(const MotionError& error, const ForwardMotion& motion, const SpeedScaleParams& params,
                      SpeedScale& scale) noexcept {
  const auto [assumed, measured, dt] = motion;
  scale.variance = std::min(scale.variance + params.scale_drift * params.scale_drift * dt, SpeedScale::unknown);
  if (params.scale_limit <= 0.0 || error.information <= 0.0 || std::abs(measured) < min_motion) return;
  const double seen = (assumed + error.forward) / measured;
  const double variance = params.scale_sigma * params.scale_sigma + 1.0 / (error.information * measured * measured);
  const double gain = scale.variance / (scale.variance + variance);
  scale.ratio += gain * (seen - scale.ratio);
  scale.variance *= 1.0 - gain;
  scale.ratio = std::clamp(scale.ratio, 1.0 - params.scale_limit, 1.0 + params.scale_limit);
}

void expect_speed(double command, double dt, const CarDynamics& car, SpeedScale& scale) noexcept {
  scale.expected += (command - scale.expected) * (1.0 - std::exp(-dt / speed_response_time(car)));
}

void learn_from_command(double measured, double dt, const SpeedScaleParams& params, SpeedScale& scale) noexcept {
  if (params.scale_limit <= 0.0) return;
  // A car that is held, braked or pushed gives no information about the scale.
  const double credible = params.scale_limit * scale.expected;
  if (std::abs(measured - scale.expected) > credible + response_slack) return;
  const double kept = std::exp(-dt / params.scale_time);
  scale.commanded_square = kept * scale.commanded_square + dt * scale.expected * scale.expected;
  scale.commanded_driven = kept * scale.commanded_driven + dt * scale.expected * measured;
}

double measured_speed_scale(const SpeedScale& scale, const SpeedScaleParams& params) noexcept {
  return 1.0 + correction(scale.ratio - 1.0, params.scale_tolerance, scale, params);
}

double command_speed_scale(const SpeedScale& scale, const SpeedScaleParams& params) noexcept {
  // After a long standstill everything is forgotten, and commands are trusted again.
  if (!(scale.commanded_square > min_driven)) return 1.0;
  const double error = scale.ratio * scale.commanded_driven / scale.commanded_square - 1.0;
  // If the walls already show that the car is faster than measured, the tolerance for commands is dropped.
  const bool fast = measured_speed_scale(scale, params) > 1.0;
  const double tolerance = fast ? 0.0 : params.command_tolerance;
  return 1.0 + std::max(0.0, correction(error, tolerance, scale, params));
}

}  // namespace firstlap
