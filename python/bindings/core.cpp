// The method: parameters, one step, and the trace of it.
#include <cstdint>

#include "arrays.hpp"
#include "firstlap/drivers/racer.hpp"
#include "laser_scan.hpp"
#include "modules.hpp"
#include "tables.hpp"

namespace firstlap::bindings {
namespace {

// Anything with x and y as rows (N, 2).
template <class Range, class ToPoint>
Numpy<double, 2> points(const Range& items, ToPoint&& to_point) {
  std::vector<double> rows;
  rows.reserve(2 * items.size());
  for (const auto& item : items) {
    const Point2 point = to_point(item);
    rows.push_back(point.x);
    rows.push_back(point.y);
  }
  return to_numpy(std::move(rows), 2);
}

template <class Range>
Numpy<double, 2> points(const Range& items) {
  return points(items, [](const auto& item) { return Point2{item.x, item.y}; });
}

nb::dict as_dict(const WallSide& side) {
  std::vector<double> rows;
  for (std::size_t i = 0; i < side.size(); ++i) {
    rows.push_back(static_cast<double>(side.x[i]));
    rows.push_back(static_cast<double>(side.y[i]));
  }
  nb::dict entry;
  entry["points"] = to_numpy(std::move(rows), 2);
  entry["outward"] = points(side.outward);
  entry["age"] = column<float>(side.age, [](float age) { return age; });
  return entry;
}

nb::dict as_dict(const Centerline& line) {
  nb::dict entry;
  entry["points"] = points(line.points);
  entry["width"] = column<double>(line.points, [](const CenterlinePoint& p) { return p.width; });
  entry["support"] = column<std::uint8_t>(line.points, [](const CenterlinePoint& p) { return p.support; });
  entry["right"] = points(line.points, [](const CenterlinePoint& p) { return p.right; });
  entry["left"] = points(line.points, [](const CenterlinePoint& p) { return p.left; });
  entry["nearest"] = line.nearest;
  entry["ahead"] = line.ahead;
  entry["end"] = static_cast<int>(line.end);
  return entry;
}

nb::dict as_dict(const Buffer<TrajectoryPoint>& path) {
  nb::dict entry;
  const auto add = [&](const char* name, double TrajectoryPoint::*member) {
    entry[name] = column<double>(path, [&](const TrajectoryPoint& p) { return p.*member; });
  };
  add("s", &TrajectoryPoint::s);
  add("x", &TrajectoryPoint::x);
  add("y", &TrajectoryPoint::y);
  add("yaw", &TrajectoryPoint::yaw);
  add("curvature", &TrajectoryPoint::curvature);
  add("velocity", &TrajectoryPoint::velocity);
  return entry;
}

nb::dict as_dict(const TrajectoryPoint& p) {
  nb::dict entry;
  entry["s"] = p.s;
  entry["x"] = p.x;
  entry["y"] = p.y;
  entry["yaw"] = p.yaw;
  entry["curvature"] = p.curvature;
  entry["velocity"] = p.velocity;
  return entry;
}

nb::dict as_dict(const SteeringTerms& terms) {
  nb::dict entry;
  entry["heading_error"] = terms.heading_error;
  entry["cross_track_error"] = terms.cross_track_error;
  entry["yaw_rate_error"] = terms.yaw_rate_error;
  entry["steering_change"] = terms.steering_change;
  entry["heading"] = terms.heading;
  entry["cross_track"] = terms.cross_track;
  entry["yaw_rate"] = terms.yaw_rate;
  entry["steering"] = terms.steering;
  entry["lookahead"] = terms.lookahead;
  entry["k_ang"] = terms.k_ang;
  entry["steering_angle"] = terms.steering_angle;
  return entry;
}

nb::dict as_dict(const Buffer<Section>& sections) {
  nb::dict entry;
  entry["first"] = column<std::int64_t>(sections, [](const Section& s) { return s.first; });
  entry["last"] = column<std::int64_t>(sections, [](const Section& s) { return s.last; });
  entry["nearest"] = column<double>(sections, [](const Section& s) { return s.nearest; });
  entry["length"] = column<double>(sections, [](const Section& s) { return s.length; });
  entry["status"] = column<std::uint8_t>(sections, [](const Section& s) { return s.status; });
  return entry;
}

nb::list as_list(const Candidates& candidates) {
  nb::list result;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    result.append(nb::make_tuple(candidates.items[i].split, candidates.items[i].score));
  }
  return result;
}

nb::tuple as_tuple(const StepResult& result) {
  return nb::make_tuple(result.command.speed, result.command.steering_angle, to_string(result.status));
}

nb::dict as_dict(const Trace& trace) {
  nb::dict entry;
  entry["points"] = points(trace.points);
  entry["point_range"] = column<double>(trace.points, [](const ScanPoint& p) { return p.range; });
  entry["point_beam"] = column<std::int64_t>(trace.points, [](const ScanPoint& p) { return p.beam; });
  entry["sections"] = as_dict(trace.sections);
  entry["samples"] = points(trace.samples);
  entry["sample_section"] = column<std::int64_t>(trace.samples, [](const SectionSample& s) { return s.section; });
  entry["sample_vote"] = column<std::int8_t>(trace.samples, [](const SectionSample& s) { return s.vote; });
  entry["candidates"] = as_list(trace.candidates);
  entry["split"] = trace.split;
  entry["left"] = as_dict(trace.walls.left);
  entry["right"] = as_dict(trace.walls.right);
  entry["line"] = as_dict(trace.line);
  entry["smoothed"] = points(trace.smoothed);
  entry["simplified"] = points(trace.simplified);
  entry["path"] = as_dict(trace.path);
  entry["nearest"] = trace.nearest;
  entry["lookahead"] = as_dict(trace.lookahead);
  entry["steering"] = as_dict(trace.steering);
  entry["width"] = trace.width;
  entry["clearance"] = trace.clearance;
  entry["speed_scale"] = trace.speed_scale;
  entry["command_scale"] = trace.command_scale;
  entry["result"] = as_tuple(trace.result);
  return entry;
}

nb::tuple step(Driver& driver, const BoundScan& scan, const VehicleState& state, double dt) {
  StepResult result;
  {
    const nb::gil_scoped_release release;
    result = driver.step(scan.scan(), state, dt);
  }
  return as_tuple(result);
}

}  // namespace

void bind_core(nb::module_& m) {
  bind_sections<Params>(m, "Params", "Every parameter of the method, in sections.");
  nb::class_<Driver>(m, "Driver", "Scan and state in, command out.")
      .def("reset", &Driver::reset, "Forgets everything.")
      .def("step", &step, nb::arg("scan"), nb::arg("state"), nb::arg("dt"),
           "Speed [m/s], wheel angle [rad] and status. dt: [s] since the scan before. Releases the GIL.");
  nb::class_<Racer, Driver>(m, "Racer", "The method: one scan in, one command out.")
      .def(nb::init<const Params&>(), nb::arg("params"), "Raises ValueError with field, value and range.")
      .def("set_params", &Racer::set_params, nb::arg("params"),
           "Changes the parameters while driving. Raises ValueError as the constructor, and then keeps the old ones.")
      .def(
          "trace", [](const Racer& racer) { return as_dict(racer.trace()); },
          "What the last step saw and thought, as numpy arrays in base_link.");
}

}  // namespace firstlap::bindings
