// Mapping and localisation: clouds, matching, occupancy grids, the localiser.
#include <cstdint>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "firstlap/maps/cloud.hpp"
#include "firstlap/maps/likelihood_field.hpp"
#include "firstlap/maps/localiser.hpp"
#include "firstlap/maps/occupancy_grid.hpp"
#include "firstlap/maps/params.hpp"
#include "firstlap/maps/scan_matcher.hpp"
#include "firstlap/maps/scan_motion.hpp"
#include "firstlap/scan_check.hpp"
#include "firstlap/sim/car.hpp"
#include "rooms.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

using maps::CloudPoint;
using maps::LocaliserParams;
using maps::MapParams;

using Ranges = nb::ndarray<const float, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Mask = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

nb::tuple as_tuple(const Pose2& pose) { return nb::make_tuple(pose.x, pose.y, pose.yaw); }

std::vector<CloudPoint> to_cloud(const Rows& rows) {
  if (rows.shape(1) != 4) throw std::invalid_argument("a cloud must be (N, 4): x, y, nx, ny");
  std::vector<CloudPoint> cloud;
  cloud.reserve(rows.shape(0));
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    const double* row = rows.data() + 4 * i;
    cloud.push_back({row[0], row[1], row[2], row[3]});
  }
  return cloud;
}

Pose2 to_pose(const nb::tuple& pose) {
  if (pose.size() != 3) throw std::invalid_argument("a pose is (x, y, yaw)");
  return {nb::cast<double>(pose[0]), nb::cast<double>(pose[1]), nb::cast<double>(pose[2])};
}

nb::tuple make_cloud(maps::CloudMaker& maker, const Ranges& ranges, double speed, double yaw_rate, double angle_min,
                     double angle_increment, double time_increment, double range_min, double range_max, double period) {
  const LaserScan scan{angle_min, angle_increment, time_increment,
                       range_min, range_max,       {ranges.data(), ranges.shape(0)}};
  if (!maker.make(scan, {speed, yaw_rate, 0.0}, period)) {
    throw std::invalid_argument(explain_fault(scan, {}, judge(scan)));
  }
  std::vector<double> cloud, points;
  for (const CloudPoint& p : maker.cloud()) cloud.insert(cloud.end(), {p.x, p.y, p.nx, p.ny});
  for (const ScanPoint& p : maker.points()) points.insert(points.end(), {p.x, p.y, p.range});
  return nb::make_tuple(to_numpy(std::move(cloud), 4), to_numpy(std::move(points), 3));
}

nb::tuple match_cloud(const Rows& rows, const maps::ReferenceCloud& reference, const nb::tuple& guess,
                      const nb::tuple& prior, const MapParams& params) {
  const std::vector<CloudPoint> cloud = to_cloud(rows);
  const Pose2 from = to_pose(guess), spread = to_pose(prior);
  maps::Match found;
  {
    const nb::gil_scoped_release release;
    found = maps::match(cloud, reference, from, {spread.x, spread.y, spread.yaw}, params.match);
  }
  std::vector<double> information(found.information.begin(), found.information.end());
  return nb::make_tuple(as_tuple(found.pose), found.fit, found.rms, to_numpy(std::move(information), 3));
}

nb::object add_scan(maps::ScanMotion& motion, const Ranges& ranges, double time, double angle_min,
                    double angle_increment, double time_increment, double range_min, double range_max) {
  const LaserScan scan{angle_min, angle_increment, time_increment,
                       range_min, range_max,       {ranges.data(), ranges.shape(0)}};
  std::optional<maps::ScanStep> step;
  {
    const nb::gil_scoped_release release;
    step = motion.add(scan, time);
  }
  if (!step) return nb::none();
  const Pose2& moved = step->motion;
  return nb::make_tuple(step->begin, step->end, moved.x, moved.y, moved.yaw, step->fit, step->along);
}

nb::tuple search_field(const maps::LikelihoodField& field, const Rows& rows, const nb::tuple& guess, double radius,
                       double angle, double step, double turn) {
  if (!(step > 0.0) || !(turn > 0.0)) throw std::invalid_argument("step and turn must be above 0");
  std::vector<maps::Beam> beams;
  for (const CloudPoint& p : to_cloud(rows)) beams.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
  const Pose2 from = to_pose(guess);
  maps::SearchResult found;
  {
    const nb::gil_scoped_release release;
    found = maps::search(beams, field, from, {radius, angle, step, turn});
  }
  return nb::make_tuple(as_tuple(found.pose), found.fit);
}

void draw(maps::OccupancyGrid& grid, const nb::tuple& pose, const std::pair<double, double>& laser,
          const Rows& points) {
  if (points.shape(1) != 3) throw std::invalid_argument("points must be (N, 3): x, y, range");
  std::vector<ScanPoint> items;
  items.reserve(points.shape(0));
  for (std::size_t i = 0; i < points.shape(0); ++i) {
    const double* row = points.data() + 3 * i;
    items.push_back({row[0], row[1], row[2], 0});
  }
  const Pose2 at = to_pose(pose);
  const nb::gil_scoped_release release;
  grid.add(at, {laser.first, laser.second}, items);
}

Numpy<std::uint8_t, 2> cells_of(const maps::OccupancyGrid& grid) {
  std::vector<std::uint8_t> cells;
  cells.reserve(static_cast<std::size_t>(grid.columns()) * static_cast<std::size_t>(grid.rows()));
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      cells.push_back(static_cast<std::uint8_t>(grid.cell(column, row)));
    }
  }
  return to_numpy(std::move(cells), static_cast<std::size_t>(grid.columns()));
}

nb::tuple as_tuple(const maps::Estimate& e) {
  return nb::make_tuple(e.pose.x, e.pose.y, e.pose.yaw, e.std, e.std_yaw, e.fit, e.searching, e.lost, e.speed_scale,
                        e.command_scale);
}

nb::tuple step(maps::Localiser& localiser, const Ranges& ranges, double speed, double yaw_rate, double steering_angle,
               double dt, double angle_min, double angle_increment, double time_increment, double range_min,
               double range_max) {
  const LaserScan scan{angle_min, angle_increment, time_increment,
                       range_min, range_max,       {ranges.data(), ranges.shape(0)}};
  maps::Estimate estimate;
  {
    const nb::gil_scoped_release release;
    estimate = localiser.step(scan, {speed, yaw_rate, steering_angle}, dt);
  }
  return as_tuple(estimate);
}

void bind_mapping(nb::module_& m) {
  bind_sections<MapParams>(m, "MapParams", "Every parameter of mapping, in sections.");
  nb::class_<maps::CloudMaker>(m, "CloudMaker", "Scans as evenly spaced clouds with normals, in base_link.")
      .def(
          "__init__",
          [](maps::CloudMaker* self, const MapParams& params, const sim::Car& car) {
            new (self) maps::CloudMaker(params.cloud, car.geometry);
          },
          nb::arg("params"), nb::arg("car"))
      .def("make", &make_cloud, nb::arg("ranges").noconvert(), nb::arg("speed"), nb::arg("yaw_rate"),
           nb::arg("angle_min"), nb::arg("angle_increment"), nb::arg("time_increment"), nb::arg("range_min"),
           nb::arg("range_max"), nb::arg("period") = 0.0,
           "cloud (N, 4) x, y, nx, ny and all points (P, 3) x, y, range. Raises ValueError for a bad header.");
  nb::class_<maps::ReferenceCloud>(m, "ReferenceCloud", "Wall points with normals, found by place.")
      .def(
          "__init__",
          [](maps::ReferenceCloud* self, const Rows& rows) { new (self) maps::ReferenceCloud(to_cloud(rows)); },
          nb::arg("points"))
      .def("__len__", &maps::ReferenceCloud::size);
  m.def("match", &match_cloud, nb::arg("cloud"), nb::arg("reference"), nb::arg("guess"), nb::arg("prior"),
        nb::arg("params"),
        "Point-to-line matching: pose (x, y, yaw) of the cloud in the reference, share of fitting points, their rms "
        "[m], and information (3, 3) in the cloud's frame. prior: standard deviations along, across, yaw.");
  nb::class_<maps::ScanMotion>(m, "ScanMotion", "How the car moved between scans, from the scans alone.")
      .def(
          "__init__",
          [](maps::ScanMotion* self, const MapParams& params, const sim::Car& car) {
            new (self) maps::ScanMotion(params.cloud, params.match, car.geometry);
          },
          nb::arg("params"), nb::arg("car"))
      .def("add", &add_scan, nb::arg("ranges").noconvert(), nb::arg("time"), nb::arg("angle_min"),
           nb::arg("angle_increment"), nb::arg("time_increment"), nb::arg("range_min"), nb::arg("range_max"),
           "begin and end [s], forward, left [m], turn [rad] since the scan that was kept before, share of points "
           "that fit, and share that tells how far the car went; None until there is something to tell. time: [s] of "
           "the last beam. Releases the GIL.")
      .def("forget", &maps::ScanMotion::forget, "As if no scan had come.");
  nb::class_<maps::OccupancyGrid>(m, "OccupancyGrid", "Beams counted in cells; row 0 is the lowest.")
      .def(
          "__init__",
          [](maps::OccupancyGrid* self, double x, double y, int columns, int rows, const MapParams& params) {
            new (self) maps::OccupancyGrid(x, y, columns, rows, params.grid);
          },
          nb::arg("x"), nb::arg("y"), nb::arg("columns"), nb::arg("rows"), nb::arg("params"))
      .def("add", &draw, nb::arg("pose"), nb::arg("laser"), nb::arg("points"),
           "Draws points (N, 3) x, y, range of base_link seen from its pose; laser: x, y of the laser there.")
      .def("cells", &cells_of, "(rows, columns) 0 free, 1 occupied, 2 unknown.");
}

void bind_localisation(nb::module_& m) {
  nb::class_<maps::LikelihoodField>(m, "LikelihoodField", "Distance to the nearest wall of a map.")
      .def(
          "__init__",
          [](maps::LikelihoodField* self, const Mask& occupied, double resolution, const nb::tuple& origin) {
            new (self) maps::LikelihoodField({occupied.data(), occupied.size()}, static_cast<int>(occupied.shape(1)),
                                             static_cast<int>(occupied.shape(0)), resolution, to_pose(origin));
          },
          nb::arg("occupied"), nb::arg("resolution"), nb::arg("origin"),
          "occupied (rows, columns) uint8, row 0 the lowest; origin (x, y, yaw) of the lower left corner.")
      .def_static(
          "of_points",
          [](const Rows& points, double resolution) { return maps::field_of(to_cloud(points), resolution); },
          nb::arg("points"), nb::arg("resolution"), "A field round a cloud (N, 4). Raises ValueError for none.")
      .def("search", &search_field, nb::arg("cloud"), nb::arg("guess"), nb::arg("radius"), nb::arg("angle"),
           nb::arg("step"), nb::arg("turn"), "Best pose on a raster round the guess, and its share of fitting points.");
  bind_sections<LocaliserParams>(m, "LocaliserParams", "Every parameter of localisation, in sections.");
  nb::class_<maps::Localiser>(m, "Localiser", "Where the car is on a map, from scans and odometry.")
      .def(
          "__init__",
          [](maps::Localiser* self, const maps::LikelihoodField& field, const sim::Car& car,
             const LocaliserParams& params,
             std::uint64_t seed) { new (self) maps::Localiser(field, car.geometry, params, seed); },
          nb::arg("field"), nb::arg("car"), nb::arg("params"), nb::arg("seed"))
      .def(
          "start",
          [](maps::Localiser& self, double x, double y, double yaw) {
            self.start({x, y, yaw});
          },
          nb::arg("x"), nb::arg("y"), nb::arg("yaw"), "base_link is about here, in the map's frame [m, rad].")
      .def(
          "displace",
          [](maps::Localiser& self, double x, double y, double yaw) {
            self.displace({x, y, yaw});
          },
          nb::arg("x"), nb::arg("y"), nb::arg("yaw"), "Shifts all that it believes, in base_link: a kidnapped car.")
      .def("step", &step, nb::arg("ranges").noconvert(), nb::arg("speed"), nb::arg("yaw_rate"),
           nb::arg("steering_angle"), nb::arg("dt"), nb::arg("angle_min"), nb::arg("angle_increment"),
           nb::arg("time_increment"), nb::arg("range_min"), nb::arg("range_max"),
           "x, y, yaw, std, std_yaw, fit, searching, lost, speed_scale, command_scale for a float32 scan. Releases the "
           "GIL.")
      .def("commanded", &maps::Localiser::commanded, nb::arg("speed"),
           "The speed command [m/s] that was given after the last step.")
      .def(
          "predict",
          [](const maps::Localiser& self, double x, double y, double yaw, double speed, double yaw_rate, double time) {
            return as_tuple(maps::predicted({x, y, yaw}, {speed, yaw_rate, 0.0}, self.params().motion, time));
          },
          nb::arg("x"), nb::arg("y"), nb::arg("yaw"), nb::arg("speed"), nb::arg("yaw_rate"), nb::arg("time"),
          "The pose so many seconds later.")
      .def_prop_ro("particles", &maps::Localiser::particles, "How many there are now.");
}

}  // namespace

void bind_maps(nb::module_& m) {
  bind_mapping(m);
  bind_localisation(m);
}

}  // namespace firstlap::bindings
