// What a run of steps leaves behind, as columns: scalars one a scan, sequences end to end with their sizes.
#pragma once

#include <cstdint>
#include <nanobind/nanobind.h>
#include <vector>

#include "firstlap/drivers/trace.hpp"

namespace firstlap::bindings {

class StepLog {
 public:
  // `trace` is null where the driver has none: then the sequences stay empty.
  void add(const StepResult& result, const Trace* trace, double microseconds);

  // Moves the columns out; the log is empty after it.
  [[nodiscard]] nanobind::dict take();

 private:
  struct Sequence {
    std::vector<double> rows;
    std::vector<std::int64_t> sizes;
  };

  static void add_side(const WallSide& side, Sequence& into, std::vector<std::int64_t>& seen);
  void add_line(const Centerline& line);
  void add_path(const Trace& trace);

  std::vector<double> speed_, steering_angle_, microseconds_;
  std::vector<std::uint8_t> status_;
  std::vector<double> width_, width_seen_, clearance_, ahead_;
  std::vector<std::int64_t> left_seen_, right_seen_;  // how many of the first rows of a side this scan saw itself
  std::vector<double> lookahead_;                     // rows of x, y
  std::vector<std::int64_t> nearest_;                 // path point next to the front axle
  Sequence left_, right_;                             // rows of x, y, age
  Sequence line_;                                     // rows of x, y, width, support
  Sequence path_;                                     // rows of s, x, y, yaw, curvature, velocity
};

}  // namespace firstlap::bindings
