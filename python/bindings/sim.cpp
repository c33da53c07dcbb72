// The simulator: track, car, lidar, race.
#include <cstdint>
#include <memory>
#include <nanobind/stl/string.h>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "callback_driver.hpp"
#include "car_sections.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

using sim::Car;
using sim::PathSample;
using sim::Race;
using sim::RaceOptions;
using sim::RaceResult;
using sim::Track;

Track make_track(const Rows& segments, const Flags& visible, const Flags& solid, const Rows& centerline) {
  if (segments.shape(1) != 4 || centerline.shape(1) != 2 || visible.shape(0) != segments.shape(0) ||
      solid.shape(0) != segments.shape(0)) {
    throw std::invalid_argument("segments must be (K, 4), visible and solid (K,), centerline (M, 2)");
  }
  std::vector<sim::WallSegment> walls;
  walls.reserve(segments.shape(0));
  for (std::size_t i = 0; i < segments.shape(0); ++i) {
    const double* row = segments.data() + 4 * i;
    walls.push_back({row[0], row[1], row[2], row[3], visible.data()[i] != 0, solid.data()[i] != 0});
  }
  Track track{sim::Walls(std::move(walls)), {}};
  for (std::size_t i = 0; i < centerline.shape(0); ++i) {
    track.centerline.push_back({centerline.data()[2 * i], centerline.data()[2 * i + 1]});
  }
  return track;
}

Car car_preset(const std::string& name) {
  if (name == "default") return sim::default_car();
  if (name == "nuc2") return sim::nuc2_car();
  if (name == "gym") return sim::gym_car();
  throw nb::key_error(name.c_str());
}

nb::dict as_dict(const sim::Lap& lap) {
  nb::dict entry;
  entry["time"] = lap.time;
  entry["distance"] = lap.distance;
  entry["mean_speed"] = lap.mean_speed;
  entry["max_speed"] = lap.max_speed;
  entry["min_clearance"] = lap.min_clearance;
  entry["rms_offset"] = lap.rms_offset;
  entry["standing"] = lap.standing;
  return entry;
}

nb::object as_dict(const std::optional<sim::Contact>& contact) {
  if (!contact) return nb::none();
  nb::dict entry;
  entry["time"] = contact->time;
  entry["x"] = contact->x;
  entry["y"] = contact->y;
  entry["s"] = contact->s;
  entry["obstacle"] = contact->obstacle;
  return entry;
}

nb::object as_dict(const std::optional<sim::ObstacleSeen>& obstacle) {
  if (!obstacle) return nb::none();
  nb::dict entry;
  entry["time"] = obstacle->time;
  entry["x"] = obstacle->middle.x;
  entry["y"] = obstacle->middle.y;
  entry["yaw"] = obstacle->middle.yaw;
  entry["speed"] = obstacle->speed;
  entry["yaw_rate"] = obstacle->yaw_rate;
  entry["clearance"] = obstacle->clearance;
  return entry;
}

nb::dict path_columns(const std::vector<PathSample>& path) {
  nb::dict columns;
  const auto add = [&](const char* name, double PathSample::*member) {
    columns[name] = column<double>(path, [&](const PathSample& sample) { return sample.*member; });
  };
  add("time", &PathSample::time);
  add("x", &PathSample::x);
  add("y", &PathSample::y);
  add("yaw", &PathSample::yaw);
  add("speed", &PathSample::speed);
  add("yaw_rate", &PathSample::yaw_rate);
  add("steering_angle", &PathSample::steering_angle);
  add("s", &PathSample::s);
  add("lateral_offset", &PathSample::lateral_offset);
  add("command_speed", &PathSample::command_speed);
  add("command_steering_angle", &PathSample::command_steering_angle);
  columns["status"] = column<std::uint8_t>(path, [](const PathSample& sample) { return sample.status; });
  return columns;
}

nb::dict as_dict(const RaceResult& result) {
  nb::list laps;
  for (const auto& lap : result.laps) laps.append(as_dict(lap));
  nb::dict entry;
  entry["outcome"] = sim::to_string(result.outcome);
  entry["time"] = result.time;
  entry["distance"] = result.distance;
  entry["laps"] = laps;
  entry["contact"] = as_dict(result.contact);
  entry["skipped_scans"] = result.skipped_scans;
  entry["obstacle"] = as_dict(result.obstacle);
  entry["compute_times"] = to_numpy(result.compute_times);
  entry["path"] = path_columns(result.path);
  return entry;
}

nb::tuple as_tuple(const Pose2& pose) { return nb::make_tuple(pose.x, pose.y, pose.yaw); }

// At most `scans` periods; false when the race is over. Raises what a driver in Python raised.
bool advance(Race& race, int scans) {
  auto* callback = dynamic_cast<CallbackDriver*>(&race.driver());
  bool going = !race.over() && !(callback && callback->failed());
  {
    const nb::gil_scoped_release release;
    for (int i = 0; i < scans && going; ++i) going = race.advance() && !(callback && callback->failed());
  }
  if (callback) callback->raise_error();
  return going;
}

void bind_race(nb::module_& m) {
  bind_sections<RaceOptions>(m, "RaceOptions", "How a race is run. The seed is an attribute of its own.")
      .def_rw("seed", &RaceOptions::seed, "64 bits; the same seed gives the same race, bit for bit.");
  nb::class_<Race>(m, "Race", "One car, one track, one driver, some laps; stepped scan by scan.")
      .def(nb::init<const Track&, const Car&, Driver&, const RaceOptions&>(), nb::arg("track"), nb::arg("car"),
           nb::arg("driver"), nb::arg("options"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 4>(),
           "Resets the driver and stands the car on the line. Raises ValueError where that cannot be.")
      .def("advance", &advance, nb::arg("scans") = 1,
           "Drives for so many scan periods, without the GIL. False when the race is over. Raises what a driver in "
           "Python raised.")
      .def(
          "result", [](const Race& race) { return as_dict(race.result()); },
          "Outcome, laps, contact, compute times [us] and path (columns, map frame, SI) so far.")
      .def(
          "laps_done", [](const Race& race) { return race.result().laps.size(); }, "Complete laps.")
      .def(
          "scan", [](const Race& race) { return BoundScan::of(race.scan()); }, "The scan that the driver saw last.")
      .def("measured", &Race::measured, "The state that the driver was given last.")
      .def("state", &Race::state, "The true state now.")
      .def_prop_ro(
          "pose", [](const Race& race) { return as_tuple(race.pose()); }, "x, y, yaw of base_link now.")
      .def_prop_ro("time", &Race::time, "[s] since the start.")
      .def_prop_ro("s", &Race::s, "[m] along the centerline.")
      .def_prop_ro("lateral_offset", &Race::lateral_offset, "[m] left of the centerline.")
      .def_prop_ro("track_length", &Race::track_length, "[m] of the centerline.");
}

// A lidar that keeps its track.
struct ScanMaker {
  sim::Lidar lidar;
  ScanMaker(const Track& track, const Car& car) : lidar(car.lidar, track.walls) {}

  Numpy<float, 1> scan(double x, double y, double yaw) {
    std::vector<float> ranges(static_cast<std::size_t>(lidar.params().beams));
    lidar.scan({x, y, yaw}, ranges);
    return to_numpy(std::move(ranges));
  }
};

}  // namespace

void bind_sim(nb::module_& m) {
  nb::class_<Track>(m, "Track", "Walls and a closed centerline, as the simulator takes them.")
      .def(
          "__init__",
          [](Track* self, const Rows& segments, const Flags& visible, const Flags& solid, const Rows& centerline) {
            new (self) Track(make_track(segments, visible, solid, centerline));
          },
          nb::arg("segments"), nb::arg("visible"), nb::arg("solid"), nb::arg("centerline"));
  bind_sections<Car>(m, "Car", "Every parameter of a simulated car, in sections.")
      .def_static("preset", &car_preset, nb::arg("name"), "The car 'default', 'nuc2' or 'gym'. Raises KeyError.");
  nb::class_<ScanMaker>(m, "Lidar", "The car's lidar on a track, without noise.")
      .def(nb::init<const Track&, const Car&>(), nb::arg("track"), nb::arg("car"), nb::keep_alive<1, 2>())
      .def("scan", &ScanMaker::scan, nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
           "Exact ranges [m] (beams,) from the laser's pose in the map frame.");
  bind_race(m);
}

}  // namespace firstlap::bindings
