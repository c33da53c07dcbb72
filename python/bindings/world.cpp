// Cars commanded from outside, for the simulator node.
#include "firstlap/sim/world.hpp"

#include <cstdint>
#include <nanobind/stl/string.h>
#include <stdexcept>
#include <string>
#include <vector>

#include "car_sections.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "tables.hpp"
#include "to_python.hpp"

namespace firstlap::sim {

template <class AnyOptions, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyOptions>, WorldOptions>
void for_each_section(AnyOptions& options, Visitor&& visit) {
  visit("world", options);
}

inline void validate(const WorldOptions& options) { firstlap::validate(options, "world"); }

}  // namespace firstlap::sim

namespace firstlap::bindings {
namespace {

using sim::World;
using sim::WorldOptions;

std::size_t checked(const World& world, std::size_t car) {
  if (car >= world.size()) throw nb::index_error("no such car");
  return car;
}

nb::dict truth(const World& world, std::size_t car) {
  checked(world, car);
  const Pose2 pose = world.pose(car);
  const VehicleState state = world.state(car);
  nb::dict entry;
  entry["x"] = pose.x;
  entry["y"] = pose.y;
  entry["yaw"] = pose.yaw;
  entry["speed"] = state.speed;
  entry["lateral_speed"] = world.lateral_speed(car);
  entry["yaw_rate"] = state.yaw_rate;
  entry["steering_angle"] = state.steering_angle;
  entry["forward_acceleration"] = world.forward_acceleration(car);
  entry["lateral_acceleration"] = world.lateral_acceleration(car);
  entry["s"] = world.s(car);
  entry["lateral_offset"] = world.lateral_offset(car);
  return entry;
}

nb::tuple own_angles(const World& world, std::size_t car) {
  sim::LidarParams params = world.car().lidar;
  params.beams = static_cast<int>(world.scan(checked(world, car)).ranges.size());
  return nb::make_tuple(params.own_angle_min(), params.own_angle_increment());
}

}  // namespace

void bind_world(nb::module_& m) {
  bind_sections<WorldOptions>(m, "WorldOptions", "Number of cars, and how they are treated.");
  nb::class_<World>(m, "World",
                    "Several identical cars on one track, commanded from outside; see cpp/firstlap/sim/world.hpp.")
      .def(nb::init<const sim::Track&, const sim::Car&, const WorldOptions&, std::uint64_t>(), nb::arg("track"),
           nb::arg("car"), nb::arg("options"), nb::arg("seed"), nb::keep_alive<1, 2>(),
           "Raises ValueError for invalid parameters or starts.")
      .def("advance", &World::advance, nb::call_guard<nb::gil_scoped_release>(),
           "Advances all cars by one scan period. Releases the GIL.")
      .def(
          "command",
          [](World& world, std::size_t car, double speed, double steering_angle, double after) {
            world.command(checked(world, car), {speed, steering_angle}, after);
          },
          nb::arg("car"), nb::arg("speed"), nb::arg("steering_angle"), nb::arg("after") = 0.0,
          "Commands speed [m/s] and steering angle [rad], `after` [s] from now.")
      .def(
          "reset", [](World& world, std::size_t car) { world.reset(checked(world, car)); }, nb::arg("car"),
          "Places the car at its start, at rest; its laps start again.")
      .def(
          "place",
          [](World& world, std::size_t car, double x, double y, double yaw) {
            world.place(checked(world, car), {x, y, yaw});
          },
          nb::arg("car"), nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
          "Places base_link at a pose [m, rad] in the map frame, at rest.")
      .def(
          "kick",
          [](World& world, std::size_t car, double lateral_speed, double yaw_rate) {
            world.kick(checked(world, car), lateral_speed, yaw_rate);
          },
          nb::arg("car"), nb::arg("lateral_speed"), nb::arg("yaw_rate"),
          "A disturbance: adds to lateral speed [m/s] and yaw rate [rad/s].")
      .def(
          "fits",
          [](const World& world, std::size_t car, double x, double y, double yaw) {
            return world.fits(checked(world, car), {x, y, yaw});
          },
          nb::arg("car"), nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
          "Whether the car can be placed there, without contact with a wall or another car.")
      .def("change", &World::change, nb::arg("car"), nb::arg("mu_scale"),
           "Changes the parameters of all cars from now on; motion and laps continue. Raises ValueError for invalid "
           "parameters, or a change of lidar.beams, lidar.rate or vehicle.model; then nothing changes.")
      .def("truth", &truth, nb::arg("car"), "Pose in the map frame and true motion, in SI units.")
      .def(
          "measured", [](const World& world, std::size_t car) { return world.measured(checked(world, car)); },
          nb::arg("car"), "The state given to the driver at the last scan.")
      .def(
          "reading", [](const World& world, std::size_t car) { return world.reading(checked(world, car)); },
          nb::arg("car"), "The measurements of the car's sensors at the last scan.")
      .def(
          "scan", [](const World& world, std::size_t car) { return BoundScan::of(world.scan(checked(world, car))); },
          nb::arg("car"), "The last scan, as drivers take it: its angles include the LiDAR's mounting.")
      .def(
          "laps", [](const World& world, std::size_t car) { return to_python(world.laps(checked(world, car))); },
          nb::sig("def laps(self, car: int) -> list[Lap]"), nb::arg("car"),
          "Completed laps since the last reset, as in a race.")
      .def(
          "laps_done", [](const World& world, std::size_t car) { return world.laps(checked(world, car)).size(); },
          nb::arg("car"), "Number of completed laps since the last reset.")
      .def(
          "contacts", [](const World& world, std::size_t car) { return world.contacts(checked(world, car)); },
          nb::arg("car"), "Number of contacts since the last reset.")
      .def(
          "clearance", [](const World& world, std::size_t car) { return world.clearance(checked(world, car)); },
          nb::arg("car"), "Smallest distance to a wall [m] since the last reset.")
      .def(
          "lap_clearance", [](const World& world, std::size_t car) { return world.lap_clearance(checked(world, car)); },
          nb::arg("car"), "Smallest distance to a wall [m] in the current lap, inf at its start.")
      .def(
          "own_angles", &own_angles, nb::arg("car") = 0,
          "angle_min, angle_increment [rad] of the last scan in the LiDAR's own frame, as its ROS driver reports them.")
      .def_prop_ro("time", &World::time, "[s]")
      .def_prop_ro("period", &World::period, "[s] between scans.")
      .def("__len__", &World::size);
}

}  // namespace firstlap::bindings
