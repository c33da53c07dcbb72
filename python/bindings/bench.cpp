// Timings inside C++, without the interpreter, on one thread.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "car_sections.hpp"
#include "firstlap/drivers/racer.hpp"
#include "modules.hpp"

namespace firstlap::bindings {
namespace {

using Clock = std::chrono::steady_clock;

double microseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

struct Recording {
  std::vector<std::vector<float>> scans;
  std::vector<VehicleState> states;
  std::vector<Pose2> lasers;
  LaserScan header;  // of all scans
};

Recording record(const sim::Track& track, const sim::Car& car, const Params& params, std::size_t scans) {
  Racer racer(params);
  sim::RaceOptions options;
  options.laps = 1000;
  options.record_path = false;
  sim::Race race(track, car, racer, options);
  Recording recording;
  while (recording.scans.size() < scans && race.advance()) {
    const LaserScan scan = race.scan();
    const Pose2 pose = race.pose();
    recording.header = scan;
    recording.scans.emplace_back(scan.ranges.begin(), scan.ranges.end());
    recording.states.push_back(race.measured());
    recording.lasers.push_back({pose.x + car.geometry.laser_x * std::cos(pose.yaw),
                                pose.y + car.geometry.laser_x * std::sin(pose.yaw), pose.yaw});
  }
  return recording;
}

std::vector<double> time_steps(const Recording& recording, const sim::Car& car, const Params& params) {
  Racer racer(params);
  std::vector<double> times;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    LaserScan scan = recording.header;
    scan.ranges = recording.scans[i];
    const auto start = Clock::now();
    racer.step(scan, recording.states[i], 1.0 / car.lidar.rate);
    times.push_back(microseconds_since(start));
  }
  return times;
}

std::vector<double> time_scans(const Recording& recording, const sim::Track& track, const sim::Car& car) {
  sim::Lidar lidar(car.lidar, track.walls);
  std::vector<float> ranges(static_cast<std::size_t>(car.lidar.beams));
  std::vector<double> times;
  for (const Pose2& laser : recording.lasers) {
    const auto start = Clock::now();
    lidar.scan(laser, ranges);
    times.push_back(microseconds_since(start));
  }
  return times;
}

// Reference for the other timings: converts every beam of a scan to a point, with cos and sin.
std::vector<double> time_reference(const Recording& recording) {
  std::vector<Point2> points(recording.header.ranges.size());
  std::vector<double> times;
  volatile double sink = 0.0;
  for (const auto& ranges : recording.scans) {
    const auto start = Clock::now();
    points.resize(ranges.size());
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double angle = recording.header.angle_min + static_cast<double>(i) * recording.header.angle_increment;
      const auto range = static_cast<double>(ranges[i]);
      points[i] = {range * std::cos(angle), range * std::sin(angle)};
    }
    sink = sink + points[points.size() / 2].x;
    times.push_back(microseconds_since(start));
  }
  return times;
}

// Simulated seconds per second of a whole race.
double time_race(const sim::Track& track, const sim::Car& car, const Params& params) {
  Racer racer(params);
  sim::RaceOptions options;
  options.laps = 5;
  options.record_path = false;
  const auto start = Clock::now();
  const sim::RaceResult result = sim::run(track, car, racer, options);
  return result.time / (1e-6 * microseconds_since(start));
}

nb::dict bench(const sim::Track& track, const sim::Car& car, const Params& params, int scans) {
  std::vector<double> steps;
  std::vector<double> lidar;
  std::vector<double> reference;
  double realtime = 0.0;
  {
    const nb::gil_scoped_release release;
    const Recording recording = record(track, car, params, static_cast<std::size_t>(std::max(scans, 1)));
    steps = time_steps(recording, car, params);
    lidar = time_scans(recording, track, car);
    reference = time_reference(recording);
    realtime = time_race(track, car, params);
  }
  nb::dict result;
  result["step_us"] = to_numpy(std::move(steps));
  result["scan_us"] = to_numpy(std::move(lidar));
  result["reference_us"] = to_numpy(std::move(reference));
  result["realtime_factor"] = realtime;
  return result;
}

}  // namespace

void bind_bench(nb::module_& m) {
  m.def("bench", &bench, nb::arg("track"), nb::arg("car"), nb::arg("params"), nb::arg("scans") = 4000,
        "Times a recorded drive: microseconds of each step, of each noise-free scan and of each run of the reference, "
        "and the real-time factor of a race.");
}

}  // namespace firstlap::bindings
