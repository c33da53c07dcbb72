// The simulator: track, car, LiDAR, race.
#include <cstdint>
#include <memory>
#include <nanobind/stl/string.h>
#include <string>
#include <utility>
#include <vector>

#include "callback_driver.hpp"
#include "car_sections.hpp"
#include "firstlap/sim/lap_search.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "tables.hpp"
#include "to_python.hpp"

namespace firstlap::bindings {
namespace {

using sim::Car;
using sim::Race;
using sim::RaceOptions;
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

// At most `scans` scan periods; false when the race is over. Rethrows the exception of a Python driver.
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
  bind_record<sim::Lap>(m, "Lap", "A completed lap.");
  bind_record<sim::Contact>(m, "Contact", "When and where the car touched a wall or the sudden obstacle.");
  bind_record<sim::ObstacleSeen>(m, "ObstacleSeen",
                                 "The sudden obstacle, once it has appeared, with its center in the map frame.");
  bind_sections<RaceOptions>(m, "RaceOptions", "Options of a race. The seed is a separate attribute.")
      .def_rw("seed", &RaceOptions::seed, "64 bits; the same seed gives the same race, bit for bit.");
  nb::class_<Race>(m, "Race", "One car on one track with one driver, stepped scan by scan.")
      .def(nb::init<const Track&, const Car&, Driver&, const RaceOptions&>(), nb::arg("track"), nb::arg("car"),
           nb::arg("driver"), nb::arg("options"), nb::keep_alive<1, 2>(), nb::keep_alive<1, 4>(),
           "Resets the driver and places the car on the start line. Raises ValueError for an invalid track, option or "
           "start.")
      .def("advance", &advance, nb::arg("scans") = 1,
           "Drives for `scans` scan periods; releases the GIL. Returns False when the race is over. Raises the "
           "exception of a Python driver.")
      .def(
          "result", [](const Race& race) { return as_dict(race.result()); },
          "The result so far; see docs/results-format.md.")
      .def(
          "laps_done", [](const Race& race) { return race.result().laps.size(); }, "Number of completed laps.")
      .def(
          "scan", [](const Race& race) { return BoundScan::of(race.scan()); }, "The last scan given to the driver.")
      .def("measured", &Race::measured, "The last state given to the driver.")
      .def("reading", &Race::reading, "The measurements of the car's sensors at the last scan.")
      .def("state", &Race::state, "The current true state.")
      .def_prop_ro("lateral_speed", &Race::lateral_speed, "[m/s] of base_link, true, left positive.")
      .def_prop_ro(
          "pose", [](const Race& race) { return as_tuple(race.pose()); },
          "Current x, y, yaw of base_link in the map frame [m, rad].")
      .def_prop_ro("time", &Race::time, "[s] since the start.")
      .def_prop_ro("s", &Race::s, "[m] along the centerline.")
      .def_prop_ro("lateral_offset", &Race::lateral_offset, "[m] left of the centerline.")
      .def_prop_ro("track_length", &Race::track_length, "[m] of the centerline.");
}

sim::LapSearchResult search_lap(const Track& track, const Car& car, const sim::LapSearchOptions& options) {
  const nb::gil_scoped_release release;
  return sim::search_lap(track, car.geometry, options);
}

void bind_lap_search(nb::module_& m) {
  bind_sections<sim::LapSearchOptions>(m, "LapSearchOptions", "Resolution and safety distance of `search_lap`.");
  m.def(
      "search_lap",
      [](const Track& track, const Car& car, const sim::LapSearchOptions& options) {
        return as_dict(search_lap(track, car, options));
      },
      nb::arg("track"), nb::arg("car"), nb::arg("options"),
      "Whether the car can drive laps of the track at all, without reverse; releases the GIL. Returns a dict, see "
      "LapSearchResult in docs/results-format.md. Raises ValueError for an invalid option or track.");
}

// A LiDAR that keeps its track alive.
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
  nb::class_<Track>(m, "Track", "Walls and a closed centerline for the simulator.")
      .def(
          "__init__",
          [](Track* self, const Rows& segments, const Flags& visible, const Flags& solid, const Rows& centerline) {
            new (self) Track(make_track(segments, visible, solid, centerline));
          },
          nb::arg("segments"), nb::arg("visible"), nb::arg("solid"), nb::arg("centerline"));
  bind_sections<Car>(m, "Car", "All parameters of a simulated car, in sections.")
      .def_static("preset", &car_preset, nb::arg("name"), "The car 'default', 'nuc2' or 'gym'. Raises KeyError.");
  nb::class_<ScanMaker>(m, "Lidar", "The car's LiDAR on a track, without noise.")
      .def(nb::init<const Track&, const Car&>(), nb::arg("track"), nb::arg("car"), nb::keep_alive<1, 2>())
      .def("scan", &ScanMaker::scan, nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
           "Exact ranges [m] (beams,) from the LiDAR's pose in the map frame [m, rad].");
  bind_race(m);
  bind_lap_search(m);
}

}  // namespace firstlap::bindings
