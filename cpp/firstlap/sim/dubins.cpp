#include "firstlap/sim/dubins.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace firstlap::sim {
namespace {

constexpr double turn = 2.0 * std::numbers::pi;

// The problem in units of the radius, with `d` between the two poses, whose headings are `a` and `b` from the line
// between them. dx and dy below lead from the center of the first circle to that of the last.
struct Problem {
  double d, a, b;

  [[nodiscard]] Problem mirrored() const noexcept { return {d, -a, -b}; }
};

// Lengths of the three pieces in units of the radius.
using Pieces = std::optional<std::array<double, 3>>;

double positive(double angle) noexcept {
  const double wrapped = std::fmod(angle, turn);
  return wrapped < 0.0 ? wrapped + turn : wrapped;
}

Pieces left_straight_left(const Problem& p) noexcept {
  const double dx = p.d + std::sin(p.a) - std::sin(p.b), dy = std::cos(p.b) - std::cos(p.a);
  const double direction = std::atan2(dy, dx);
  return {{positive(direction - p.a), std::hypot(dx, dy), positive(p.b - direction)}};
}

Pieces left_straight_right(const Problem& p) noexcept {
  const double dx = p.d + std::sin(p.a) + std::sin(p.b), dy = -std::cos(p.a) - std::cos(p.b);
  const double squared = dx * dx + dy * dy - 4.0;
  if (squared < 0.0) return std::nullopt;
  const double straight = std::sqrt(squared);
  const double direction = std::atan2(dy, dx) + std::atan2(2.0, straight);
  return {{positive(direction - p.a), straight, positive(direction - p.b)}};
}

Pieces left_right_left(const Problem& p) noexcept {
  const double dx = p.d + std::sin(p.a) - std::sin(p.b), dy = std::cos(p.b) - std::cos(p.a);
  const double between = std::hypot(dx, dy);
  if (between > 4.0) return std::nullopt;
  const double middle = turn - 2.0 * std::asin(0.25 * between);
  const double to_middle = std::atan2(dy, dx) + std::acos(0.25 * between);  // from the first circle to the middle one
  const double first = positive(to_middle + 0.5 * std::numbers::pi - p.a);
  return {{first, middle, positive(p.b - p.a - first + middle)}};
}

void add(const Pieces& pieces, std::array<double, 3> turns, double radius, std::vector<DubinsPath>& out) {
  if (!pieces) return;
  DubinsPath path{};
  for (std::size_t i = 0; i < path.size(); ++i) path[i] = {turns[i] / radius, (*pieces)[i] * radius};
  out.push_back(path);
}

}  // namespace

Pose2 along(const Pose2& from, const Arc& arc) noexcept {
  const double turned = arc.curvature * arc.length;
  // The chord of the arc: sin(x) / x, without the division by zero of a straight.
  const double half = 0.5 * turned, ratio = std::abs(half) < 1e-6 ? 1.0 : std::sin(half) / half;
  const double chord = arc.length * ratio;
  return {from.x + chord * std::cos(from.yaw + half), from.y + chord * std::sin(from.yaw + half), from.yaw + turned};
}

double length(const DubinsPath& path) noexcept { return path[0].length + path[1].length + path[2].length; }

std::vector<DubinsPath> dubins_paths(const Pose2& from, const Pose2& to, double radius) {
  const double dx = to.x - from.x, dy = to.y - from.y, direction = std::atan2(dy, dx);
  const Problem left{std::hypot(dx, dy) / radius, from.yaw - direction, to.yaw - direction};
  const Problem right = left.mirrored();  // right turns are the left turns of the mirror image
  std::vector<DubinsPath> paths;
  add(left_straight_left(left), {1.0, 0.0, 1.0}, radius, paths);
  add(left_straight_left(right), {-1.0, 0.0, -1.0}, radius, paths);
  add(left_straight_right(left), {1.0, 0.0, -1.0}, radius, paths);
  add(left_straight_right(right), {-1.0, 0.0, 1.0}, radius, paths);
  add(left_right_left(left), {1.0, -1.0, 1.0}, radius, paths);
  add(left_right_left(right), {-1.0, 1.0, -1.0}, radius, paths);
  std::sort(paths.begin(), paths.end(), [](const DubinsPath& a, const DubinsPath& b) { return length(a) < length(b); });
  return paths;
}

}  // namespace firstlap::sim
