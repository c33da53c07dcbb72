#include "callback_driver.hpp"

#include <cmath>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.hpp"

namespace firstlap::bindings {
namespace {

constexpr Status all_statuses[] = {Status::ok,      Status::holding,  Status::no_path,
                                   Status::blocked, Status::bad_scan, Status::bad_state};

Status status_named(const std::string& name) {
  for (const Status status : all_statuses)
    if (name == to_string(status)) return status;
  throw std::invalid_argument("the driver gave the unknown status '" + name + "'");
}

nb::dict header_of(const LaserScan& scan) {
  nb::dict header;
  header["angle_min"] = scan.angle_min;
  header["angle_increment"] = scan.angle_increment;
  header["time_increment"] = scan.time_increment;
  header["range_min"] = scan.range_min;
  header["range_max"] = scan.range_max;
  return header;
}

StepResult to_result(const nb::object& answer) {
  const auto [speed, steering_angle, status] = nb::cast<std::tuple<double, double, std::string>>(answer);
  if (!std::isfinite(speed) || !std::isfinite(steering_angle))
    throw std::invalid_argument("the driver gave a command that is not finite");
  return {{speed, steering_angle}, status_named(status)};
}

}  // namespace

StepResult CallbackDriver::step(const LaserScan& scan, const VehicleState& state, double dt) noexcept {
  if (!failed_) {
    const nb::gil_scoped_acquire gil;
    try {
      const StepResult result =
          to_result(driver_.attr("step")(to_numpy(std::vector<float>(scan.ranges.begin(), scan.ranges.end())),
                                         state.speed, state.yaw_rate, state.steering_angle, dt, header_of(scan)));
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
