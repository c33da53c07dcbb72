#include "firstlap/sim/lap_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <queue>
#include <unordered_set>
#include <utility>

#include "firstlap/sim/contact.hpp"
#include "firstlap/sim/dubins.hpp"

namespace firstlap::sim {
namespace {

constexpr double check_spacing = 0.05;   // [m] between poses that are checked for contact
constexpr double rounding = 1e-9;        // parts of an arc
constexpr double wall_cell = 0.25;       // [m] of the grid of walls
constexpr double field_cell = 0.05;      // [m] of the distance field
constexpr double max_field_cells = 4e6;  // a larger track gets a coarser field
constexpr double max_turn = 0.35;        // [rad] of one arc of the search
constexpr double arc_cells = 2.0;        // length of an arc in cells, so that it leaves its cell
constexpr double progress_bin = 8.0;     // [m] the same pose on another part of the lap is another state
constexpr double enough_gain = 1.0;      // [m] of progress after which coarse cells do again
constexpr double closing_reach = 3.0;    // [m] along the track within which a lap is closed
constexpr double closing_spacing = 0.4;  // [m] between the poses that a lap is closed at
constexpr double closing_detour = 2.0;   // a closing path may be longer than the distance by this many radii
constexpr std::array<double, 7> steering{0.0, 0.25, -0.25, 0.5, -0.5, 1.0, -1.0};  // shares of the largest curvature

CarGeometry enlarged(CarGeometry car, double margin) noexcept {
  car.width += 2.0 * margin;
  car.length += 2.0 * margin;
  car.rear_overhang += margin;
  return car;
}

Walls solid_only(const Walls& walls) {
  std::vector<WallSegment> solid;
  std::copy_if(walls.segments().begin(), walls.segments().end(), std::back_inserter(solid),
               [](const WallSegment& wall) { return wall.solid; });
  return Walls(std::move(solid), wall_cell);
}

// Whether the car's rectangle is clear of the walls. Disks along the rectangle and a distance field, filled as needed,
// answer for most poses; the exact test answers for those near a wall.
class Body {
 public:
  Body(const Walls& walls, const CarGeometry& car) : walls_(solid_only(walls)), car_(car) {
    const Footprint body(car);
    const auto disks = static_cast<std::size_t>(std::ceil(2.0 * car.length / car.width));
    const double half = 0.5 * car.length / static_cast<double>(disks);
    for (std::size_t i = 0; i < disks; ++i) disks_.push_back(body.rear + half * static_cast<double>(2 * i + 1));
    disk_radius_ = std::hypot(half, body.side);
    place_field();
  }

  bool clear(const Pose2& pose) {
    const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
    const bool far = std::all_of(disks_.begin(), disks_.end(),
                                 [&](double x) { return at_least(pose.x + x * c, pose.y + x * s, disk_radius_); });
    return far || (inside(pose.x, pose.y) && !touch(car_, pose, walls_));
  }

 private:
  void place_field() {
    low_ = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    Point2 high{-low_.x, -low_.y};
    for (const WallSegment& w : walls_.segments()) {
      low_ = {std::min({low_.x, w.x1, w.x2}), std::min({low_.y, w.y1, w.y2})};
      high = {std::max({high.x, w.x1, w.x2}), std::max({high.y, w.y1, w.y2})};
    }
    if (walls_.segments().empty()) return;
    const double width = high.x - low_.x, height = high.y - low_.y;
    while ((width / cell_ + 1.0) * (height / cell_ + 1.0) > max_field_cells) cell_ *= 2.0;
    columns_ = static_cast<int>(width / cell_) + 1;
    rows_ = static_cast<int>(height / cell_) + 1;
    field_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1.0F);
  }

  bool inside(double x, double y) const noexcept {
    const double column = std::floor((x - low_.x) / cell_), row = std::floor((y - low_.y) / cell_);
    return column >= 0.0 && row >= 0.0 && column < columns_ && row < rows_;
  }

  // Whether no wall is within `radius`, as far as the field tells.
  bool at_least(double x, double y, double radius) {
    if (!inside(x, y)) return false;
    const int column = static_cast<int>((x - low_.x) / cell_), row = static_cast<int>((y - low_.y) / cell_);
    float& known =
        field_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)];
    if (known < 0.0F) {
      const Point2 middle{low_.x + (column + 0.5) * cell_, low_.y + (row + 0.5) * cell_};
      const double safe = walls_.nearest_distance(middle) - cell_ * std::numbers::sqrt2 / 2.0;
      known = static_cast<float>(std::max(safe, 0.0));
    }
    return known > radius;
  }

  Walls walls_;
  CarGeometry car_;
  std::vector<double> disks_;  // [m] x of their centers in base_link
  double disk_radius_ = 0.0;
  Point2 low_{};
  double cell_ = field_cell;
  int columns_ = 0, rows_ = 0;
  std::vector<float> field_;  // [m] at most the distance from any point of the cell to the walls; < 0: unknown yet
};

struct State {
  Pose2 pose{};
  double traveled = 0.0;  // [m] along the centerline since the start
  double best = 0.0;      // [m] largest `traveled` on the way here
  int parent = -1;
  Arc arc{};  // from the parent
};

// One level of refinement: cells, headings, and the arcs that lead from one cell to others.
struct Level {
  double cell = 0.0, heading = 0.0;  // [m], [rad]
  std::array<Arc, steering.size()> arcs{};
};

struct Farthest {
  double traveled;
  int state;
  bool operator<(const Farthest& other) const noexcept { return traveled < other.traveled; }
};

// Number of parts of an arc, so that poses between them are close enough to check.
int parts_of(const Arc& arc) noexcept {
  return std::max(1, static_cast<int>(std::ceil(arc.length / check_spacing - rounding)));
}

class LapSearch {
 public:
  LapSearch(const Track& track, const CarGeometry& car, const LapSearchOptions& options)
      : progress_(track.centerline),
        body_(track.walls, enlarged(car, options.margin)),
        options_(options),
        radius_(1.0 / tightest_curvature(car)) {
    for (int i = 0; i <= options.refinements; ++i) levels_.push_back(level(i));
  }

  LapSearchResult run() {
    states_.push_back({progress_.pose_at(0.0)});
    if (!body_.clear(states_[0].pose)) return result(LapVerdict::blocked);
    for (std::size_t i = 0; i < levels_.size();) {
      const double before = states_[farthest_].traveled;
      open_window();
      expand(i, i == 0 ? std::numeric_limits<double>::infinity() : before + enough_gain);
      if (closed_) return result(LapVerdict::drivable);
      if (full()) return result(LapVerdict::undecided);
      i = states_[farthest_].traveled >= before + enough_gain ? 0 : i + 1;
    }
    return result(LapVerdict::blocked);
  }

 private:
  struct Closing {
    int from = 0, to = 0;
    DubinsPath path{};
  };

  Level level(int refinement) const {
    const double share = std::exp2(-refinement);
    Level made{options_.cell * share, 2.0 * std::numbers::pi / options_.headings * share};
    for (std::size_t i = 0; i < steering.size(); ++i) {
      const double curvature = steering[i] / radius_;
      made.arcs[i] = {curvature, std::min(arc_cells * made.cell, max_turn / std::abs(curvature))};
    }
    return made;
  }

  bool full() const noexcept { return states_.size() >= static_cast<std::size_t>(options_.max_states); }

  // Every state from `window` before the farthest one on is tried again.
  void open_window() {
    open_ = {};
    const double from = states_[farthest_].traveled - options_.window;
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i].traveled >= from) open_.push({states_[i].traveled, static_cast<int>(i)});
    }
  }

  // Extends the state farthest along the track, again and again, until a lap is closed or a state is at `enough`.
  void expand(std::size_t level, double enough) {
    while (!open_.empty() && !full()) {
      const int at = open_.top().state;
      open_.pop();
      if (states_[static_cast<std::size_t>(at)].traveled >= enough || close(at)) return;
      if (states_[static_cast<std::size_t>(at)].traveled >= 2.0 * progress_.length()) continue;
      for (const Arc& arc : levels_[level].arcs) extend(at, arc, level);
    }
  }

  void extend(int at, const Arc& arc, std::size_t level) {
    const State& from = states_[static_cast<std::size_t>(at)];
    const Pose2 pose = along(from.pose, arc);
    const auto cell = key(pose, from.traveled, level);
    if (visited_.contains(cell) || !clear(from.pose, arc)) return;
    const double s = std::fmod(from.traveled + progress_.length(), progress_.length());
    const double step = std::remainder(progress_.locate_near(s, {pose.x, pose.y}).s - s, progress_.length());
    const double traveled = from.traveled + step, best = std::max(from.best, traveled);
    if (traveled < best - options_.wrong_way_distance) return;
    visited_.insert(cell);
    open_.push({traveled, static_cast<int>(states_.size())});
    if (traveled > states_[farthest_].traveled) farthest_ = states_.size();
    states_.push_back({pose, traveled, best, at, arc});
  }

  std::uint64_t key(const Pose2& pose, double traveled, std::size_t level) const noexcept {
    const auto part = [](double value, int bits) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value))) & ((1ULL << bits) - 1);
    };
    const Level& at = levels_[level];
    const double yaw = std::remainder(pose.yaw, 2.0 * std::numbers::pi) + std::numbers::pi;
    return part(pose.x / at.cell, 16) | part(pose.y / at.cell, 16) << 16 | part(yaw / at.heading, 16) << 32 |
           part(traveled / progress_bin, 13) << 48 | static_cast<std::uint64_t>(level) << 61;
  }

  bool clear(const Pose2& from, const Arc& arc) {
    const int parts = parts_of(arc);
    for (int i = parts; i > 0; --i) {
      if (!body_.clear(along(from, {arc.curvature, arc.length * i / parts}))) return false;
    }
    return true;
  }

  // Whether a state a lap later can be joined to one of those that it came from.
  bool close(int at) {
    const State& end = states_[static_cast<std::size_t>(at)];
    const double lap_before = end.traveled - progress_.length();
    if (lap_before < -closing_reach) return false;
    double last = std::numeric_limits<double>::infinity();
    for (int i = at; i >= 0; i = states_[static_cast<std::size_t>(i)].parent) {
      const State& begin = states_[static_cast<std::size_t>(i)];
      if (begin.traveled < lap_before) break;
      if (begin.traveled > lap_before + closing_reach || std::abs(begin.traveled - last) < closing_spacing) continue;
      last = begin.traveled;
      if (join(at, i)) return true;
    }
    return false;
  }

  bool join(int from, int to) {
    const Pose2 end = states_[static_cast<std::size_t>(from)].pose, begin = states_[static_cast<std::size_t>(to)].pose;
    const double longest = std::hypot(begin.x - end.x, begin.y - end.y) + closing_detour * radius_;
    for (const DubinsPath& path : dubins_paths(end, begin, radius_)) {
      if (length(path) > longest) break;
      Pose2 at = end;
      const bool free = std::all_of(path.begin(), path.end(), [&](const Arc& arc) {
        const bool is_clear = clear(at, arc);
        at = along(at, arc);
        return is_clear;
      });
      if (free) closed_ = Closing{from, to, path};
      if (free) return true;
    }
    return false;
  }

  LapSearchResult result(LapVerdict verdict) const {
    LapSearchResult found{verdict, states_[farthest_].traveled, static_cast<int>(states_.size())};
    std::vector<int> chain;
    for (int i = closed_ ? closed_->from : static_cast<int>(farthest_); i >= 0;
         i = states_[static_cast<std::size_t>(i)].parent) {
      chain.push_back(i);
    }
    found.path.push_back(states_[0].pose);
    for (auto i = chain.rbegin(); i != chain.rend(); ++i) {
      const State& state = states_[static_cast<std::size_t>(*i)];
      if (state.parent >= 0) append(state.arc, found.path);
      if (closed_ && *i == closed_->to) found.lap_start = static_cast<int>(found.path.size()) - 1;
    }
    if (closed_)
      std::for_each(closed_->path.begin(), closed_->path.end(), [&](const Arc& arc) { append(arc, found.path); });
    return found;
  }

  static void append(const Arc& arc, std::vector<Pose2>& path) {
    const Pose2 from = path.back();
    const int parts = parts_of(arc);
    for (int i = 1; i <= parts; ++i) path.push_back(along(from, {arc.curvature, arc.length * i / parts}));
  }

  Progress progress_;
  Body body_;
  LapSearchOptions options_;
  double radius_;  // [m] of the turning circle of base_link
  std::vector<Level> levels_;
  std::vector<State> states_;
  std::unordered_set<std::uint64_t> visited_;
  std::priority_queue<Farthest> open_;
  std::size_t farthest_ = 0;
  std::optional<Closing> closed_;
};

}  // namespace

LapSearchResult search_lap(const Track& track, const CarGeometry& car, const LapSearchOptions& options) {
  validate(options, "lap_search");
  return LapSearch(track, car, options).run();
}

}  // namespace firstlap::sim
