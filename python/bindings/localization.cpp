// Localization: the likelihood field and the particle filter on it.
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "arrays.hpp"
#include "clouds.hpp"
#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/localization/localizer.hpp"
#include "firstlap/sim/car.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "records.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

using localization::LocalizerParams;
using mapping::CloudPoint;

nb::tuple search_field(const localization::LikelihoodField& field, const Rows& rows, const nb::tuple& guess,
                       double radius, double angle, double step, double turn) {
  if (!(step > 0.0) || !(turn > 0.0)) throw std::invalid_argument("step and turn must be above 0");
  std::vector<localization::Beam> beams;
  for (const CloudPoint& p : to_cloud(rows)) beams.push_back({static_cast<float>(p.x), static_cast<float>(p.y)});
  const Pose2 from = to_pose(guess);
  localization::SearchResult found;
  {
    const nb::gil_scoped_release release;
    found = localization::search(beams, field, from, {radius, angle, step, turn});
  }
  return nb::make_tuple(as_values(found.pose), found.fit);
}

localization::Estimate step(localization::Localizer& localizer, const BoundScan& scan, const VehicleState& state,
                            double dt) {
  const nb::gil_scoped_release release;
  return localizer.step(scan.scan(), state, dt);
}

}  // namespace

void bind_localization(nb::module_& m) {
  bind_record<localization::Estimate>(m, "Estimate", "Pose of base_link in the map's frame at the end of the sweep.");
  nb::class_<localization::LikelihoodField>(m, "LikelihoodField", "Distance to the nearest wall of an occupancy map.")
      .def(
          "__init__",
          [](localization::LikelihoodField* self, const Mask& occupied, double resolution, const nb::tuple& origin) {
            new (self)
                localization::LikelihoodField({occupied.data(), occupied.size()}, static_cast<int>(occupied.shape(1)),
                                              static_cast<int>(occupied.shape(0)), resolution, to_pose(origin));
          },
          nb::arg("occupied"), nb::arg("resolution"), nb::arg("origin"),
          "occupied: (rows, columns) uint8, row 0 the lowest, nonzero for walls; resolution: [m] cell size; origin: "
          "(x, y, yaw) [m, rad] of the lower left corner in the map.")
      .def_static(
          "of_points",
          [](const Rows& points, double resolution) { return localization::field_of(to_cloud(points), resolution); },
          nb::arg("points"), nb::arg("resolution"),
          "A field around a cloud (N, 4). Raises ValueError for an empty cloud.")
      .def("search", &search_field, nb::arg("cloud"), nb::arg("guess"), nb::arg("radius"), nb::arg("angle"),
           nb::arg("step"), nb::arg("turn"),
           "Exhaustive search around the guess (x, y, yaw). Returns the best pose, and the share of points that match. "
           "radius, step: [m]; angle, turn: [rad].");
  bind_sections<LocalizerParams>(m, "LocalizerParams", "All parameters of localization, in sections.");
  nb::class_<localization::Localizer>(m, "Localizer", "Localization on a map from scans and odometry.")
      .def(
          "__init__",
          [](localization::Localizer* self, const localization::LikelihoodField& field, const sim::Car& car,
             const LocalizerParams& params, std::uint64_t seed) {
            new (self) localization::Localizer(field, {car.geometry, car.vehicle}, params, seed);
          },
          nb::arg("field"), nb::arg("car"), nb::arg("params"), nb::arg("seed"))
      .def(
          "start",
          [](localization::Localizer& self, double x, double y, double yaw) {
            self.start({x, y, yaw});
          },
          nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
          "Sets the start pose: base_link is near (x, y, yaw) in the map's frame [m, rad].")
      .def(
          "displace",
          [](localization::Localizer& self, double x, double y, double yaw) {
            self.displace({x, y, yaw});
          },
          nb::arg("x"), nb::arg("y"), nb::arg("yaw"),
          "Shifts all estimates by (x, y, yaw) in base_link [m, rad], as if the car had been moved by hand.")
      .def("step", &step, nb::arg("scan"), nb::arg("state"), nb::arg("dt"),
           "Returns the estimate at the end of the sweep. dt: [s] since the previous scan. Releases the GIL.")
      .def("commanded", &localization::Localizer::commanded, nb::arg("speed"),
           "The speed command [m/s] given after the last step.")
      .def(
          "predict",
          [](const localization::Localizer& self, const nb::tuple& pose, const VehicleState& state, double time) {
            return as_values(localization::predicted(to_pose(pose), state, self.params().motion, time));
          },
          nb::arg("pose"), nb::arg("state"), nb::arg("time"),
          "The pose (x, y, yaw) `time` seconds later, at the measured speed and yaw rate.")
      .def_prop_ro("particles", &localization::Localizer::particles, "Current number of particles.");
}

}  // namespace firstlap::bindings
