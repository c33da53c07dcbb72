// A scan as Python holds it: its ranges are a numpy array, which is not copied.
#pragma once

#include <span>
#include <vector>

#include "arrays.hpp"
#include "firstlap/common/types.hpp"
#include "views.hpp"

namespace firstlap::bindings {

class BoundScan {
 public:
  BoundScan(Ranges ranges, const LaserScan& header) : ranges_(std::move(ranges)), scan_(header) {
    scan_.ranges = {ranges_.data(), ranges_.shape(0)};
  }

  // With a copy of the ranges.
  static BoundScan of(const LaserScan& scan) {
    const nb::object copy = nb::cast(to_numpy(std::vector<float>(scan.ranges.begin(), scan.ranges.end())));
    return {nb::cast<Ranges>(copy), scan};
  }

  [[nodiscard]] const Ranges& ranges() const noexcept { return ranges_; }
  [[nodiscard]] const LaserScan& scan() const noexcept { return scan_; }

 private:
  Ranges ranges_;
  LaserScan scan_;
};

}  // namespace firstlap::bindings
