// A driver that is written in Python, racing in the same simulator as the others.
#pragma once

#include <exception>
#include <nanobind/nanobind.h>
#include <utility>

#include "firstlap/common/driver.hpp"

namespace firstlap::bindings {

namespace nb = nanobind;

// Calls `step(scan, state, dt)` and `reset()` of a Python object, taking the GIL for it. What the object raises is kept
// for `raise_error`; from then on the car is told to stop.
class CallbackDriver final : public Driver {
 public:
  explicit CallbackDriver(nb::object driver) : driver_(std::move(driver)) {}

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override;

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  // Throws what the Python object raised, once.
  void raise_error();

 private:
  void fail() noexcept;

  nb::object driver_;
  std::exception_ptr error_;
  bool failed_ = false;
  double steering_ = 0.0;  // [rad] last commanded
};

}  // namespace firstlap::bindings
