#include "firstlap/drivers/racer_memory.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "firstlap/drivers/racer.hpp"
#include "support/random_inputs.hpp"

namespace firstlap {

struct RacerProbe {
  static Trace& trace(Racer& racer) { return racer.trace_; }
  static RacerWorkspace& workspace(Racer& racer) { return racer.work_; }
};

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr float nan_f = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t all = std::numeric_limits<std::size_t>::max();  // as many as fit

void spoil(WallSide& side) {
  side.x.fill(all, nan_f);
  side.y.fill(all, nan_f);
  side.outward.fill(all, {nan, nan});
  side.sight.fill(all, {nan_f, nan_f, nan_f, true});
  side.age.fill(all, nan_f);
  side.seen = side.size();
}

void spoil(LocalWalls& walls) {
  spoil(walls.left);
  spoil(walls.right);
}

void spoil(Centerline& line) {
  line.points.fill(all, {nan, nan, nan, WallSupport::both, {nan, nan}, {nan, nan}, true});
  line.nearest = 7;
  line.ahead = nan;
  line.end = LineEnd::too_narrow;
}

void spoil(Trace& trace) {
  trace.points.fill(all, {nan, nan, nan, 3});
  trace.sections.fill(all, {0, 1, 1, nan, nan, nan, SectionStatus::kept});
  trace.samples.fill(all, {nan, nan, 0, 1, {nan_f, nan_f, 1.0F, true}});
  trace.candidates.items.fill({0, nan});
  trace.candidates.count = max_candidates;
  trace.split = 5;
  spoil(trace.walls);
  spoil(trace.line);
  trace.smoothed.fill(all, {nan, nan});
  trace.simplified.fill(all, {nan, nan});
  trace.path.fill(all, {nan, nan, nan, nan, nan, nan});
  trace.nearest = 9;
  trace.lookahead = {nan, nan, nan, nan, nan, nan};
  trace.steering.steering_angle = trace.steering.lookahead = nan;
  trace.width = trace.clearance = trace.speed_scale = trace.command_scale = nan;
  trace.result = {{nan, nan}, Status::holding};
}

void spoil(RacerWorkspace& work) {
  spoil(work.step);
  work.table.prepare(scene::Scan{.angle_min = 0.1, .ranges = std::vector<float>(33, 1.0F)}.view());
  work.ranges.fill(all, nan_f);
  spoil(work.walls);
  spoil(work.line);
  Buffer<Point2> other(3);
  for (const double x : {4.0, 5.0, 7.0}) other.push({x, -x});
  work.spline.fit(other);
  work.widths.fill(all, nan);
  work.control_points.fill(all, {{nan, nan}, {nan, nan}, nan, nan, nan, {nan, nan}, nan});
}

bool same_bits(const StepResult& a, const StepResult& b) {
  return std::memcmp(&a.command, &b.command, sizeof a.command) == 0 && a.status == b.status;
}

// Laps of a winding track, with valid and invalid scans and states.
struct Drive {
  explicit Drive(std::uint64_t seed) : random(seed) {}

  struct Input {
    scene::Scan scan;
    VehicleState state;
    double dt;
  };
  Input next() {
    const int i = count++;
    if (i % 20 == 19) return {random.scan(), random.state(), random.dt()};
    return {track.scan(course.at(1.0 + 0.08 * (i % 150))), {3.0, random.uniform(-0.5, 0.5), 0.0}, 0.025};
  }

  scene::RandomInputs random;
  scene::Course course = scene::Course{}.straight(3).turn(1.2, 3.1).turn(1.2, -3.1).straight(8);
  scene::Scene track = course.pipes(1.8, 1.0, 0.3);
  int count = 0;
};

Params minimum_curvature() {
  Params params;
  params.minimum_curvature.bend_passes = 30;
  return params;
}

TEST(RacerState, a_step_does_not_depend_on_the_contents_of_workspace_and_trace) {
  const auto seed = scene::seed_or(31);
  for (const Params& params : {Params{}, minimum_curvature()}) {
    Drive drive(seed);
    Racer clean{params}, spoiled{params};
    int followed = 0;
    for (int i = 0; i < scene::count_or(240); ++i) {
      const Drive::Input in = drive.next();
      spoil(RacerProbe::workspace(spoiled));
      spoil(RacerProbe::trace(spoiled));
      const StepResult result = clean.step(in.scan.view(), in.state, in.dt);
      ASSERT_TRUE(same_bits(result, spoiled.step(in.scan.view(), in.state, in.dt))) << scene::how_to_repeat(seed, i);
      followed += result.status == Status::ok;
    }
    EXPECT_GT(followed, scene::count_or(240) / 2) << "the whole method must have run";
  }
}

TEST(RacerState, the_trace_shows_only_this_step) {
  Drive drive(scene::seed_or(32));
  Racer racer{Params{}};
  for (int i = 0; i < 10; ++i) {
    const Drive::Input in = drive.next();
    racer.step(in.scan.view(), in.state, in.dt);
  }
  ASSERT_GT(racer.trace().walls.left.size(), 0U);
  EXPECT_EQ(racer.step(scene::Scan{}.view(), {3.0, 0.0, 0.0}, 0.025).status, Status::holding);
  EXPECT_EQ(racer.trace().walls.left.size() + racer.trace().walls.right.size(), 0U) << "no wall was visible";
  EXPECT_GT(racer.trace().path.size(), 4U) << "the held path";
}

TEST(RacerState, a_racer_restored_from_the_memory_of_another_behaves_identically) {
  const auto seed = scene::seed_or(33);
  for (int start = 0; start < scene::count_or(6); ++start) {
    Drive drive(seed);
    Racer first{Params{}}, second{Params{}};
    for (int i = 0; i < 10 + 29 * start; ++i) {
      const Drive::Input in = drive.next();
      first.step(in.scan.view(), in.state, in.dt);
    }
    second.restore(first.memory());
    for (int i = 0; i < 30; ++i) {
      const Drive::Input in = drive.next();
      const StepResult expected = first.step(in.scan.view(), in.state, in.dt);
      ASSERT_TRUE(same_bits(expected, second.step(in.scan.view(), in.state, in.dt)))
          << scene::how_to_repeat(seed, start);
    }
  }
}

}  // namespace
}  // namespace firstlap
