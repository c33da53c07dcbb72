#include "callback_driver.hpp"

#include <cmath>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "laser_scan.hpp"

namespace firstlap::bindings {
namespace {

Status status_named(const std::string& name) {
  for (const Status status : statuses)
    if (name == to_string(status)) return status;
  throw std::invalid_argument("the driver returned the unknown status '" + name + "'");
}

StepResult to_result(const nb::object& answer) {
  const auto [speed, steering_angle, status] = nb::cast<std::tuple<double, double, std::string>>(answer);
  if (!std::isfinite(speed) || !std::isfinite(steering_angle))
    throw std::invalid_argument("the driver returned a command that is not finite");
  return {{speed, steering_angle}, status_named(status)};
}

}  // namespace

StepResult CallbackDriver::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  if (!failed_) {
    const nb::gil_scoped_acquire gil;
    try {
      const StepResult result = to_result(driver_.attr("step")(BoundScan::of(scan), state, dt));
      steering_ = result.command.steering_angle;
      return result;
    } catch (...) {
      fail();
    }
  }
  return {{0.0, steering_}, Status::no_path};
}

void CallbackDriver::reset() noexcept {
  const nb::gil_scoped_acquire gil;
  failed_ = false;
  error_ = nullptr;
  steering_ = 0.0;
  try {
    driver_.attr("reset")();
  } catch (...) {
    fail();
  }
}

void CallbackDriver::fail() noexcept {
  failed_ = true;
  error_ = std::current_exception();
}

void CallbackDriver::raise_error() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

}  // namespace firstlap::bindings
