// Poses and clouds from Python.
#pragma once

#include <stdexcept>
#include <vector>

#include "arrays.hpp"
#include "firstlap/mapping/cloud.hpp"
#include "views.hpp"

namespace firstlap::bindings {

inline std::vector<mapping::CloudPoint> to_cloud(const Rows& rows) {
  if (rows.shape(1) != 4) throw std::invalid_argument("a cloud must be (N, 4): x, y, nx, ny");
  std::vector<mapping::CloudPoint> cloud;
  cloud.reserve(rows.shape(0));
  for (std::size_t i = 0; i < rows.shape(0); ++i) {
    const double* row = rows.data() + 4 * i;
    cloud.push_back({row[0], row[1], row[2], row[3]});
  }
  return cloud;
}

inline Pose2 to_pose(const nb::tuple& pose) {
  if (pose.size() != 3) throw std::invalid_argument("a pose is (x, y, yaw)");
  return {nb::cast<double>(pose[0]), nb::cast<double>(pose[1]), nb::cast<double>(pose[2])};
}

}  // namespace firstlap::bindings
