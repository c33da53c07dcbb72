#include "firstlap/mapping/scan_motion.hpp"

#include <algorithm>
#include <span>

namespace firstlap::mapping {
namespace {

constexpr double interval = 0.09;  // [s] minimum duration of a step while tracking; longer steps are more accurate
constexpr double longest = 0.6;    // [s] maximum duration of a step
constexpr double good_fit = 0.85;  // above this fit no second guess is tried
constexpr double lost_fit = 0.5;   // below this fit the velocity is unknown
// A weak prior: the scans decide, and the guess counts only where they give no information.
constexpr Prior weak{0.5, 0.5, 0.5};

std::span<const CloudPoint> points_of(const CloudMaker& maker) { return {maker.cloud().begin(), maker.cloud().end()}; }

// Share of all points that constrain the cloud along x, after y and yaw are eliminated.
double share_along(const Match& match, const MatchParams& params, std::size_t points) {
  const auto& h = match.information;
  const double det = h[4] * h[8] - h[5] * h[5];
  if (points == 0 || !(det > 0.0)) return 0.0;
  const double taken = (h[1] * h[1] * h[8] - 2.0 * h[1] * h[2] * h[5] + h[2] * h[2] * h[4]) / det;
  return std::max(h[0] - taken, 0.0) * params.sigma * params.sigma / static_cast<double>(points);
}

}  // namespace

ScanMotion::ScanMotion(const CloudParams& cloud, const MatchParams& match, const CarGeometry& car)
    : maker_(cloud, car), match_(match) {}

std::optional<ScanStep> ScanMotion::add(const LaserScan& scan, double time) {
  period_.learn(time - heard_);
  heard_ = time;
  const double elapsed = kept_ ? time - kept_->time : 0.0;
  if (kept_ && elapsed >= 0.0 && elapsed < (tracking_ ? interval : 0.0)) return {};
  const VehicleState own{velocity_.x, velocity_.yaw, 0.0};
  if (!maker_.make(scan, tracking_ ? own : VehicleState{}, period_.seconds())) return {};
  if (!kept_ || !(elapsed > 0.0) || elapsed > longest) {
    tracking_ = false;
    keep(time);
    return {};
  }
  const Match found = best_match(elapsed);
  const ScanStep step{kept_->time, time, found.pose, found.fit, share_along(found, match_, points_of(maker_).size())};
  tracking_ = found.fit >= lost_fit;
  velocity_ = {found.pose.x / elapsed, found.pose.y / elapsed, found.pose.yaw / elapsed};
  keep(time);
  return step;
}

// Matches from the last velocity; if that does not fit, also from standstill.
Match ScanMotion::best_match(double elapsed) const noexcept {
  const Pose2 rolled{velocity_.x * elapsed, velocity_.y * elapsed, velocity_.yaw * elapsed};
  const auto from = [&](const Pose2& guess) { return match(points_of(maker_), kept_->cloud, guess, weak, match_); };
  if (!tracking_) return from({});
  const Match first = from(rolled);
  if (first.fit >= good_fit) return first;
  const Match second = from({});
  return second.fit > first.fit ? second : first;
}

void ScanMotion::keep(double time) { kept_.emplace(Kept{time, ReferenceCloud(points_of(maker_))}); }

}  // namespace firstlap::mapping
