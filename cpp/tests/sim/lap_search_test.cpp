#include "firstlap/sim/lap_search.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <stdexcept>

#include "firstlap/sim/contact.hpp"
#include "support/sim_scene.hpp"

namespace firstlap::sim {
namespace {

using testing::annulus;
using testing::wavy_track;

double turning_radius(const CarGeometry& car) { return car.wheelbase / std::tan(car.steering_limit); }

CarGeometry enlarged(CarGeometry car, double margin) {
  car.width += 2.0 * margin;
  car.length += 2.0 * margin;
  car.rear_overhang += margin;
  return car;
}

// A closed polyline as walls.
void add_ring(const std::vector<Point2>& corners, std::vector<WallSegment>& out) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point2 a = corners[i], b = corners[(i + 1) % corners.size()];
    out.push_back({a.x, a.y, b.x, b.y});
  }
}

// A rectangle of `width` across with a thin wall in the middle that ends 2.6 m before each end: two lanes, and a U-turn
// at each end with nothing in its way but the two long sides. Driven counterclockwise. The walls at which the U-turns
// end have a bulge `bulge` deep.
Track hairpins(double width, double bulge = 0.0) {
  const double end = 4.6, tip = 2.0, half = 0.5 * width, lane = 0.25 * width;
  std::vector<WallSegment> walls;
  std::vector<Point2> outer;
  for (const double side : {-1.0, 1.0}) {  // the lower wall to the right, then the upper one to the left
    outer.push_back({side * end, side * half});
    for (const auto& [x, y] : {Point2{2.1, 0.0}, {2.1, bulge}, {0.3, bulge}, {0.3, 0.0}}) {
      if (bulge > 0.0) outer.push_back({side * (tip + x), side * (half + y)});
    }
    outer.push_back({-side * end, side * half});
  }
  add_ring(outer, walls);
  walls.push_back({-tip, 0.0, tip, 0.0});
  std::vector<Point2> center;
  const int points = 60;
  for (int i = 0; i < points; ++i) center.push_back({-tip + 2.0 * tip * i / points, -lane});
  for (int i = 0; i < points; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / points - 0.5);
    center.push_back({tip + lane * std::cos(angle), lane * std::sin(angle)});
  }
  for (int i = 0; i < points; ++i) center.push_back({tip - 2.0 * tip * i / points, lane});
  for (int i = 0; i < points; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / points + 0.5);
    center.push_back({-tip + lane * std::cos(angle), lane * std::sin(angle)});
  }
  return {Walls(std::move(walls)), std::move(center)};
}

// Between parallel walls, a U-turn at full lock needs the radius and half of the body on the side where it begins, and
// the circle of the outer front corner on the other.
double width_of_a_u_turn(const CarGeometry& car, double margin) {
  const CarGeometry body = enlarged(car, margin);
  const double beside = turning_radius(car) + 0.5 * body.width;
  return beside + std::hypot(beside, body.length - body.rear_overhang);
}

// An annulus with a throat: two parallel walls, `width` apart, 1.2 m long, at its rightmost point; it starts at the
// leftmost. The walls of the throat are the last six.
Track throat(double width) {
  const double radius = 5.0, beyond = 0.55, half_length = 0.6;
  Track track = annulus(radius, 0.5);
  std::vector<WallSegment> walls(track.walls.segments().begin(), track.walls.segments().end());
  for (const double side : {-1.0, 1.0}) {
    const double inner = radius + side * 0.5 * width, outer = radius + side * beyond;
    walls.push_back({inner, -half_length, inner, half_length});
    walls.push_back({inner, -half_length, outer, -half_length});
    walls.push_back({inner, half_length, outer, half_length});
  }
  track.walls = Walls(std::move(walls));
  std::rotate(track.centerline.begin(), track.centerline.begin() + 1800, track.centerline.end());
  return track;
}

Track reversed(const Track& track) {
  Track other = track;
  std::reverse(other.centerline.begin() + 1, other.centerline.end());
  return other;
}

void expect_a_proof(const LapSearchResult& found, const Track& track, const CarGeometry& car, double margin) {
  ASSERT_EQ(found.verdict, LapVerdict::drivable);
  const CarGeometry body = enlarged(car, margin);
  const double sharpest = 1.0 / turning_radius(car);
  Progress progress(track.centerline);
  for (std::size_t i = 0; i < found.path.size(); ++i) {
    const Pose2& at = found.path[i];
    ASSERT_FALSE(touch(body, at, track.walls).has_value()) << "pose " << i;
    if (i == static_cast<std::size_t>(found.lap_start)) progress.reset({at.x, at.y});
    progress.update({at.x, at.y});
    if (i == 0) continue;
    const Pose2& before = found.path[i - 1];
    const double step = std::hypot(at.x - before.x, at.y - before.y), turned = at.yaw - before.yaw;
    ASSERT_LE(step, 0.0501);
    ASSERT_LE(2.0 * std::abs(std::sin(0.5 * turned)), step * sharpest + 1e-9) << "a chord of a circle at full lock";
    // The chord of an arc halves its turn: the car moves forward, and not sideways.
    ASSERT_NEAR(-std::sin(before.yaw + 0.5 * turned) * (at.x - before.x) +
                    std::cos(before.yaw + 0.5 * turned) * (at.y - before.y),
                0.0, 1e-9);
    ASSERT_GE(std::cos(before.yaw) * (at.x - before.x) + std::sin(before.yaw) * (at.y - before.y), -1e-9);
  }
  const Pose2 &begin = found.path[static_cast<std::size_t>(found.lap_start)], &end = found.path.back();
  EXPECT_NEAR(std::hypot(end.x - begin.x, end.y - begin.y), 0.0, 1e-6);
  EXPECT_NEAR(std::remainder(end.yaw - begin.yaw, 2.0 * std::numbers::pi), 0.0, 1e-6);
  EXPECT_NEAR(progress.traveled(), progress.length(), 1e-6) << "once around";
}

TEST(LapSearch, a_lap_that_is_found_is_a_proof) {
  const CarGeometry car;
  for (const Track& track : {annulus(5.0, 0.6), wavy_track(), wavy_track(400, 0.45)}) {
    for (const Track& way : {track, reversed(track)}) expect_a_proof(search_lap(way, car), way, car, 0.02);
  }
}

TEST(LapSearch, a_u_turn_between_walls_needs_the_width_of_the_closed_form) {
  CarGeometry car;
  for (const double steering : {car.steering_limit, 0.3}) {
    for (const double margin : {0.0, 0.05}) {
      car.steering_limit = steering;
      const double needed = width_of_a_u_turn(car, margin);
      const Track wider = hairpins(needed + 0.09), narrower = hairpins(needed - 0.02);
      expect_a_proof(search_lap(wider, car, {.margin = margin}), wider, car, margin);
      const LapSearchResult blocked = search_lap(narrower, car, {.margin = margin, .refinements = 1});
      EXPECT_EQ(blocked.verdict, LapVerdict::blocked) << steering << ' ' << margin;
      EXPECT_GT(blocked.path.back().x, 1.5) << "it gets to the first U-turn";
      EXPECT_LT(blocked.traveled, 8.0) << "and not along the lane behind it";
    }
  }
}

TEST(LapSearch, a_throat_needs_the_width_of_the_body) {
  const CarGeometry car;
  for (const double margin : {0.0, 0.05}) {
    const double body = car.width + 2.0 * margin;
    const Track wider = throat(body + 0.04), narrower = throat(body - 0.01);
    for (const Track& track : {wider, reversed(wider)}) {
      expect_a_proof(search_lap(track, car, {.margin = margin}), track, car, margin);
    }
    for (const Track& track : {narrower, reversed(narrower)}) {
      EXPECT_EQ(search_lap(track, car, {.margin = margin, .refinements = 1}).verdict, LapVerdict::blocked);
    }
  }
}

// The front corner swings out in the second half of a U-turn. A bulge of the wall there, too short to begin a U-turn
// in, helps the direction that ends at it.
TEST(LapSearch, a_bulge_on_one_side_lets_one_direction_through) {
  CarGeometry car;
  car.length = 1.1;
  const double width = width_of_a_u_turn(car, 0.0) - 0.2;
  const Track without = hairpins(width), with = hairpins(width, 0.4);
  const LapSearchOptions once{.margin = 0.0, .refinements = 1};
  EXPECT_EQ(search_lap(without, car, once).verdict, LapVerdict::blocked);
  expect_a_proof(search_lap(with, car, {.margin = 0.0}), with, car, 0.0);
  EXPECT_EQ(search_lap(reversed(with), car, once).verdict, LapVerdict::blocked);
}

TEST(LapSearch, halving_the_resolution_does_not_change_the_answer) {
  const CarGeometry car;
  const double needed = width_of_a_u_turn(car, 0.02);
  const LapSearchOptions coarse{.refinements = 1}, fine{.cell = 0.05, .headings = 144, .refinements = 1};
  for (const double width : {needed - 0.03, needed + 0.09}) {
    EXPECT_EQ(search_lap(hairpins(width), car, coarse).verdict, search_lap(hairpins(width), car, fine).verdict)
        << width;
  }
}

TEST(LapSearch, a_start_in_contact_is_blocked_at_once) {
  const LapSearchResult found = search_lap(annulus(5.0, 0.1), CarGeometry{});
  EXPECT_EQ(found.verdict, LapVerdict::blocked);
  EXPECT_EQ(found.traveled, 0.0);
  EXPECT_EQ(found.path.size(), 1U);
}

TEST(LapSearch, too_many_states_are_undecided) {
  EXPECT_EQ(search_lap(hairpins(1.7), CarGeometry{}, {.max_states = 1000}).verdict, LapVerdict::undecided);
}

TEST(LapSearch, walls_that_are_not_solid_are_passed) {
  Track track = throat(0.2);
  std::vector<WallSegment> walls(track.walls.segments().begin(), track.walls.segments().end());
  EXPECT_EQ(search_lap(track, CarGeometry{}).verdict, LapVerdict::blocked);
  for (auto wall = walls.end() - 6; wall != walls.end(); ++wall) wall->solid = false;
  track.walls = Walls(std::move(walls));
  EXPECT_EQ(search_lap(track, CarGeometry{}).verdict, LapVerdict::drivable);
}

TEST(LapSearch, an_invalid_option_names_its_range) {
  EXPECT_THROW(search_lap(annulus(5.0, 1.0), CarGeometry{}, {.cell = 0.0}), std::invalid_argument);
  EXPECT_THROW(search_lap(annulus(5.0, 1.0), CarGeometry{}, {.margin = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace firstlap::sim
