// Mapping: clouds, scan matching, occupancy grids.
#include <cstdint>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "clouds.hpp"
#include "firstlap/mapping/cloud.hpp"
#include "firstlap/mapping/occupancy_grid.hpp"
#include "firstlap/mapping/params.hpp"
#include "firstlap/mapping/scan_matcher.hpp"
#include "firstlap/mapping/scan_motion.hpp"
#include "firstlap/perception/scan_check.hpp"
#include "firstlap/sim/car.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "records.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

using mapping::CloudPoint;
using mapping::MapParams;

nb::tuple make_cloud(mapping::CloudMaker& maker, const BoundScan& bound, const VehicleState& state, double period) {
  const LaserScan& scan = bound.scan();
  if (!maker.make(scan, state, period)) {
    throw std::invalid_argument(describe_fault(scan, {}, check_scan(scan)));
  }
  std::vector<double> cloud, points;
  for (const CloudPoint& p : maker.cloud()) cloud.insert(cloud.end(), {p.x, p.y, p.nx, p.ny});
  for (const ScanPoint& p : maker.points()) points.insert(points.end(), {p.x, p.y, p.range});
  return nb::make_tuple(to_numpy(std::move(cloud), 4), to_numpy(std::move(points), 3));
}

nb::tuple match_cloud(const Rows& rows, const mapping::ReferenceCloud& reference, const nb::tuple& guess,
                      const nb::tuple& prior, const MapParams& params) {
  const std::vector<CloudPoint> cloud = to_cloud(rows);
  const Pose2 from = to_pose(guess), spread = to_pose(prior);
  mapping::Match found;
  {
    const nb::gil_scoped_release release;
    found = mapping::match(cloud, reference, from, {spread.x, spread.y, spread.yaw}, params.match);
  }
  std::vector<double> information(found.information.begin(), found.information.end());
  return nb::make_tuple(as_values(found.pose), found.fit, found.rms, to_numpy(std::move(information), 3));
}

nb::object add_scan(mapping::ScanMotion& motion, const BoundScan& scan, double time) {
  std::optional<mapping::ScanStep> step;
  {
    const nb::gil_scoped_release release;
    step = motion.add(scan.scan(), time);
  }
  if (!step) return nb::none();
  const Pose2& moved = step->motion;
  return nb::make_tuple(step->begin, step->end, moved.x, moved.y, moved.yaw, step->fit, step->along);
}

void draw(mapping::OccupancyGrid& grid, const nb::tuple& pose, const std::pair<double, double>& laser,
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

Numpy<std::uint8_t, 2> cells_of(const mapping::OccupancyGrid& grid) {
  std::vector<std::uint8_t> cells;
  cells.reserve(static_cast<std::size_t>(grid.columns()) * static_cast<std::size_t>(grid.rows()));
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      cells.push_back(static_cast<std::uint8_t>(grid.cell(column, row)));
    }
  }
  return to_numpy(std::move(cells), static_cast<std::size_t>(grid.columns()));
}

}  // namespace

void bind_mapping(nb::module_& m) {
  bind_sections<MapParams>(m, "MapParams", "All parameters of mapping, in sections.");
  nb::class_<mapping::CloudMaker>(m, "CloudMaker", "Converts scans to evenly spaced clouds with normals, in base_link.")
      .def(
          "__init__",
          [](mapping::CloudMaker* self, const MapParams& params, const sim::Car& car) {
            new (self) mapping::CloudMaker(params.cloud, car.geometry);
          },
          nb::arg("params"), nb::arg("car"))
      .def("make", &make_cloud, nb::arg("scan"), nb::arg("state"), nb::arg("period") = 0.0,
           "Returns the cloud (N, 4) x, y, nx, ny and all points (P, 3) x, y, range, in base_link [m]. period: [s] "
           "between scans, 0 if unknown. Raises ValueError for an invalid scan.");
  nb::class_<mapping::ReferenceCloud>(
      m, "ReferenceCloud", "Wall points with normals, (N, 4) x, y, nx, ny, in a grid for nearest-neighbor search.")
      .def(
          "__init__",
          [](mapping::ReferenceCloud* self, const Rows& rows) { new (self) mapping::ReferenceCloud(to_cloud(rows)); },
          nb::arg("points"))
      .def("__len__", &mapping::ReferenceCloud::size);
  m.def("match", &match_cloud, nb::arg("cloud"), nb::arg("reference"), nb::arg("guess"), nb::arg("prior"),
        nb::arg("params"),
        "Point-to-line matching. Returns the pose (x, y, yaw) of the cloud in the reference, the share of points that "
        "match, their RMS distance [m], and the information matrix (3, 3) in the cloud's frame. prior: standard "
        "deviations along [m], across [m], yaw [rad] of the guess.");
  nb::class_<mapping::ScanMotion>(m, "ScanMotion", "Motion of the car between scans, from the scans alone.")
      .def(
          "__init__",
          [](mapping::ScanMotion* self, const MapParams& params, const sim::Car& car) {
            new (self) mapping::ScanMotion(params.cloud, params.match, car.geometry);
          },
          nb::arg("params"), nb::arg("car"))
      .def("add", &add_scan, nb::arg("scan"), nb::arg("time"),
           "Returns begin and end [s], forward and left [m], turn [rad] since the reference scan, the share of points "
           "that match, and the share that constrains the forward motion; None if there is no motion to report yet. "
           "time: [s] of the last beam. Releases the GIL.")
      .def("forget", &mapping::ScanMotion::forget, "Clears all earlier scans.");
  nb::class_<mapping::OccupancyGrid>(m, "OccupancyGrid",
                                     "Counts the beams that pass or end in each cell; row 0 is the lowest.")
      .def(
          "__init__",
          [](mapping::OccupancyGrid* self, double x, double y, int columns, int rows, const MapParams& params) {
            new (self) mapping::OccupancyGrid(x, y, columns, rows, params.grid);
          },
          nb::arg("x"), nb::arg("y"), nb::arg("columns"), nb::arg("rows"), nb::arg("params"))
      .def("add", &draw, nb::arg("pose"), nb::arg("laser"), nb::arg("points"),
           "Adds points (N, 3) x, y, range in base_link, with base_link at `pose` (x, y, yaw) in the map. laser: (x, "
           "y) of the LiDAR in base_link.")
      .def("cells", &cells_of, "(rows, columns) uint8: 0 free, 1 occupied, 2 unknown.");
}

}  // namespace firstlap::bindings
