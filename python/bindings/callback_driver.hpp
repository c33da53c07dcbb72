// A driver written in Python, in the same simulator as the others.
#pragma once

#include <exception>
#include <nanobind/nanobind.h>
#include <utility>

#include "firstlap/common/driver.hpp"

namespace firstlap::bindings {

namespace nb = nanobind;

// Calls `step(scan, state, dt)` and `reset()` of a Python object, holding the GIL. An exception of the object is kept
// for `raise_error`; from then on the command is to stop.
class CallbackDriver final : public Driver {
 public:
  explicit CallbackDriver(nb::object driver) : driver_(std::move(driver)) {}

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override;

  [[nodiscard]] bool failed() const noexcept { return failed_; }
  // Rethrows the exception of the Python object, once.
  void raise_error();

 private:
  void fail() noexcept;

  nb::object driver_;
  std::exception_ptr error_;
  bool failed_ = false;
  double steering_ = 0.0;  // [rad] last command
};

}  // namespace firstlap::bindings
