#include "firstlap/sim/progress.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firstlap::sim {
namespace {

constexpr double window = 2.0;  // [m] of arc length searched in both directions

double gap(Point2 a, Point2 b) { return std::hypot(b.x - a.x, b.y - a.y); }

}  // namespace

Progress::Progress(std::span<const Point2> centerline) {
  for (const Point2 p : centerline) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) throw std::invalid_argument("centerline: a point is not finite");
    if (points_.empty() || gap(points_.back(), p) > 0.0) points_.push_back(p);
  }
  while (points_.size() > 1 && gap(points_.back(), points_.front()) == 0.0) points_.pop_back();
  if (points_.size() < 3) throw std::invalid_argument("centerline: fewer than three different points");
  for (std::size_t i = 0; i < points_.size(); ++i) {
    s_.push_back(length_);
    length_ += gap(points_[i], points_[next(i)]);
  }
  s_.push_back(length_);
}

Pose2 Progress::pose_at(double s) const noexcept {
  double wrapped = std::fmod(s, length_);
  if (wrapped < 0.0) wrapped += length_;
  const std::size_t i = index_at(wrapped);
  const Point2 a = points_[i], b = points_[next(i)];
  const double t = (wrapped - s_[i]) / (s_[i + 1] - s_[i]);
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), std::atan2(b.y - a.y, b.x - a.x)};
}

std::size_t Progress::index_at(double s) const noexcept {
  const auto after = std::upper_bound(s_.begin(), s_.end() - 1, s);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - s_.begin() - 1, 0));
}

Progress::Candidate Progress::project(std::size_t i, Point2 p) const noexcept {
  const Point2 a = points_[i], b = points_[next(i)];
  const double dx = b.x - a.x, dy = b.y - a.y, px = p.x - a.x, py = p.y - a.y;
  const double t = std::clamp((px * dx + py * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  const double ex = px - t * dx, ey = py - t * dy;
  const double distance = std::sqrt(ex * ex + ey * ey);
  const double s = s_[i] + t * (s_[i + 1] - s_[i]);
  return {i, s < length_ ? s : 0.0, std::copysign(distance, dx * py - dy * px), distance};
}

Projection Progress::locate(Point2 point) const noexcept {
  Candidate best = project(0, point);
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Candidate candidate = project(i, point);
    if (candidate.distance < best.distance) best = candidate;
  }
  return {best.s, best.offset};
}

void Progress::reset(Point2 point) noexcept {
  place_ = locate(point);
  index_ = index_at(place_.s);
  traveled_ = 0.0;
}

Progress::Candidate Progress::nearest_around(std::size_t index, double s, Point2 point) const noexcept {
  const double reach = std::min(window, 0.25 * length_);
  Candidate best = project(index, point);
  const auto consider = [&](std::size_t i) {
    const Candidate candidate = project(i, point);
    if (candidate.distance < best.distance) best = candidate;
  };
  double ahead = s_[index + 1] - s;
  for (std::size_t i = next(index); ahead < reach; i = next(i)) {
    consider(i);
    ahead += s_[i + 1] - s_[i];
  }
  double behind = s - s_[index];
  for (std::size_t i = previous(index); behind < reach; i = previous(i)) {
    consider(i);
    behind += s_[i + 1] - s_[i];
  }
  return best;
}

Projection Progress::locate_near(double s, Point2 point) const noexcept {
  const Candidate best = nearest_around(index_at(s), s, point);
  return {best.s, best.offset};
}

void Progress::update(Point2 point) noexcept { accept(nearest_around(index_, place_.s, point)); }

void Progress::accept(const Candidate& best) noexcept {
  traveled_ += std::remainder(best.s - place_.s, length_);
  place_ = {best.s, best.offset};
  index_ = best.index;
}

}  // namespace firstlap::sim
