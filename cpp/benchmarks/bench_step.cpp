// A whole step on a 1081-beam scan, and the time of each stage.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "firstlap/perception/wall_memory.hpp"
#include "firstlap/planning/velocity_profile.hpp"
#include "support/scene.hpp"

namespace {

using namespace firstlap;
using scene::Course;
using scene::pi;

Course course_of(std::int64_t kind) {
  switch (kind) {
    case 0: return Course{}.straight(30);
    case 1: return Course{}.turn(3.0, 1.9 * pi);
    default: return Course{}.straight(6).turn(1.2, pi).straight(8);
  }
}
const char* name_of(std::int64_t kind) { return kind == 0 ? "corridor" : kind == 1 ? "annulus" : "hairpin"; }

// Scans along a course with the LiDAR's noise, so that the branch predictor cannot learn them.
struct Lap {
  explicit Lap(std::int64_t kind) {
    const Course course = course_of(kind);
    const scene::Scene scene = course.walls(1.8);
    std::mt19937 generator(1);
    std::normal_distribution<float> noise(0.0F, 0.01F);
    for (double s = 3.0; s < course.length() - 5.0; s += 0.05) {
      scans.push_back(scene.scan(course.at(s)));
      for (float& r : scans.back().ranges) r += noise(generator);
      const double yaw_rate = (course.at(s).yaw - course.at(s - 0.05).yaw) / 0.025;
      states.push_back({2.0, yaw_rate, 0.0});
    }
  }
  std::vector<scene::Scan> scans;
  std::vector<VehicleState> states;
};

// Inputs of every stage, from the stages before it, for scan i of a lap.
struct Stages {
  explicit Stages(std::int64_t kind) : lap(kind) {
    for (std::size_t i = 0; i < lap.scans.size() / 2; ++i) racer.step(lap.scans[i].view(), lap.states[i], 0.025);
    scan = lap.scans[lap.scans.size() / 2];
    table.prepare(scan.view());
    racer.step(scan.view(), {2.0, 0.0, 0.0}, 0.025);
  }
  Lap lap;
  Params params;
  Racer racer{params};
  scene::Scan scan;
  BeamTable table;
};

void report_percentiles(benchmark::State& state, std::vector<double>& us) {
  std::sort(us.begin(), us.end());
  state.counters["p50_us"] = us[us.size() / 2];
  state.counters["p99_us"] = us[us.size() * 99 / 100];
  state.counters["max_us"] = us.back();
}

void step(benchmark::State& state) {
  const Lap lap(state.range(0));
  Racer racer{Params{}};
  std::vector<double> us;
  us.reserve(1 << 20);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(racer.step(lap.scans[i].view(), lap.states[i], 0.025));
    const auto end = std::chrono::steady_clock::now();
    if (us.size() < us.capacity()) us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
    if (++i == lap.scans.size()) {
      i = 0;
      racer.reset();
    }
  }
  report_percentiles(state, us);
  state.SetLabel(name_of(state.range(0)));
}

// The reference: one pass of sine and cosine over as many beams.
void reference_sincos(benchmark::State& state) {
  for (auto _ : state) {
    double sum = 0.0;
    for (int i = 0; i < 1081; ++i) sum += std::sin(0.004 * i) + std::cos(0.004 * i);
    benchmark::DoNotOptimize(sum);
  }
}

void stage_scan_to_points(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<ScanPoint> points(max_points);
  for (auto _ : state) {
    scan_to_points(s.scan.view(), s.table, {}, s.params.scan, s.params.car, points);
    benchmark::DoNotOptimize(points.data());
  }
}

void stage_segment(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<Section> sections(max_sections);
  for (auto _ : state) {
    segment(s.racer.trace().points, s.table.angle_step(), 1.8, s.params.segmentation, sections);
    benchmark::DoNotOptimize(sections.data());
  }
}

void stage_sample_sections(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<SectionSample> samples(max_samples);
  for (auto _ : state) {
    sample_sections(s.racer.trace().points, s.racer.trace().sections, CarGeometry{}, 0.15, s.params.segmentation,
                    samples);
    benchmark::DoNotOptimize(samples.data());
  }
}

void stage_vote_by_past(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<SectionSample> samples(max_samples);
  sample_sections(s.racer.trace().points, s.racer.trace().sections, CarGeometry{}, 0.15, s.params.segmentation,
                  samples);
  for (auto _ : state) {
    label_from_history(s.racer.trace().walls, s.racer.trace().path, Buffer<TrailPoint>(1), s.params.segmentation,
                       samples);
    benchmark::DoNotOptimize(samples.data());
  }
}

void stage_sides(benchmark::State& state) {
  Stages s(state.range(0));
  const Trace& t = s.racer.trace();
  LocalWalls walls;
  for (auto _ : state) {
    const Candidates c = rank_splits({t.points, t.sections, t.samples}, 1.8, s.params.segmentation);
    split_into_sides({t.points, t.sections, t.samples}, {c.items[0].split, 1.8, 0.15}, s.params.car,
                     s.params.segmentation, walls);
    benchmark::DoNotOptimize(walls.left.x.data());
  }
}

void stage_recall_hidden(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<float> ranges(max_points);
  LocalWalls walls;
  for (auto _ : state) {
    walls.left.clear();
    walls.right.clear();
    ranges_by_beam(s.racer.trace().points, s.table.size(), ranges);
    carry_over_occluded(s.racer.trace().walls, {s.table, ranges, s.params.car}, 0.8, walls);
    benchmark::DoNotOptimize(walls.left.x.data());
  }
}

void stage_trace_centerline(benchmark::State& state) {
  Stages s(state.range(0));
  const Buffer<TrailPoint> trail(1);
  Centerline line;
  for (auto _ : state) {
    trace_centerline({s.racer.trace().walls, trail, 1.8}, {s.params.car, s.params.track_width, s.params.centerline},
                     line);
    benchmark::DoNotOptimize(line.points.data());
  }
  state.counters["samples"] =
      static_cast<double>(s.racer.trace().walls.left.size() + s.racer.trace().walls.right.size());
}

void stage_trajectory(benchmark::State& state) {
  Stages s(state.range(0));
  const TrajectoryParams& p = s.params.trajectory;
  Buffer<Point2> smoothed(max_line_points);
  Buffer<Point2> keys(max_line_points);
  Buffer<TrajectoryPoint> path(max_path_points);
  Spline spline(max_line_points);
  for (auto _ : state) {
    smooth_between_walls(s.racer.trace().line.points, s.params.car, p, smoothed);
    join_car(1.5, 0.78, smoothed);
    simplify_opheim(smoothed, p.opheim_min, p.opheim_max, keys);
    sample_path(keys, p.sample, p.end_hold, spline, path);
    benchmark::DoNotOptimize(path.data());
  }
}

void stage_velocity_profile(benchmark::State& state) {
  Stages s(state.range(0));
  Buffer<TrajectoryPoint> path(max_path_points);
  path.assign(s.racer.trace().path.span());
  for (auto _ : state) {
    plan_velocity(2.0, s.racer.trace().nearest, s.params.velocity_profile, path);
    benchmark::DoNotOptimize(path.data());
  }
}

void stage_stanley(benchmark::State& state) {
  Stages s(state.range(0));
  TrajectoryPoint point;
  for (auto _ : state)
    benchmark::DoNotOptimize(track_path({s.racer.trace().path, s.racer.trace().nearest, {2.0, 0.0, 0.0}, 0.0},
                                        s.params.stanley, s.params.car, point));
}

BENCHMARK(reference_sincos)->Unit(benchmark::kMicrosecond);
BENCHMARK(step)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_scan_to_points)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_segment)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_sample_sections)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_vote_by_past)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_sides)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_recall_hidden)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_trace_centerline)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_trajectory)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_velocity_profile)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);
BENCHMARK(stage_stanley)->DenseRange(0, 2)->Unit(benchmark::kMicrosecond);

}  // namespace
