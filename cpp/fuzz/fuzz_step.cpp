// Any bytes as parameters, scans, states and intervals: Racer::step gives finite commands within limits.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "firstlap/drivers/racer.hpp"

namespace {

using namespace firstlap;

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  [[nodiscard]] bool empty() const { return at_ >= size_; }

  template <class T>
  T take() {
    T value{};
    const std::size_t n = std::min(sizeof value, size_ - at_);
    std::memcpy(&value, data_ + at_, n);
    at_ += n;
    return value;
  }
  // Any double, or one in a plausible range.
  double number(double low, double high) {
    const auto kind = take<std::uint8_t>();
    if (kind < 16) return take<double>();
    return low + (high - low) * take<std::uint16_t>() / 65535.0;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
};

Params random_params(Bytes& bytes) {
  Params params;
  if (bytes.take<std::uint8_t>() < 128) return params;
  for_each_section(params, [&](std::string_view, auto& section) {
    for_each_field<std::remove_reference_t<decltype(section)>>([&](const auto& field) {
      if (bytes.take<std::uint8_t>() < 200) return;
      auto& value = section.*(field.member);
      const double share = bytes.take<std::uint8_t>() / 255.0;
      value = static_cast<std::remove_reference_t<decltype(value)>>(field.min + share * (field.max - field.min));
    });
  });
  try {
    validate(params);
  } catch (const std::invalid_argument&) {
    return {};
  }
  return params;
}

void random_ranges(Bytes& bytes, std::vector<float>& ranges) {
  const std::size_t sizes[] = {0, 1, 2, 7, 60, 271, 1081, 2500};
  ranges.assign(sizes[bytes.take<std::uint8_t>() % 8], 0.0F);
  // Segments of a ramp: walls, jumps, and sometimes any float.
  for (std::size_t i = 0; i < ranges.size();) {
    const std::size_t run = 1 + bytes.take<std::uint8_t>();
    double r = bytes.take<std::uint8_t>() / 16.0;
    const double slope = bytes.take<std::int8_t>() / 1024.0;
    const bool raw = bytes.take<std::uint8_t>() < 8;
    for (std::size_t k = 0; k < run && i < ranges.size(); ++k, ++i, r += slope)
      ranges[i] = raw ? bytes.take<float>() : static_cast<float>(r);
    if (bytes.empty() && i > 0) {  // the rest repeats the data so far
      for (std::size_t k = i; k < ranges.size(); ++k) ranges[k] = ranges[k - i];
      return;
    }
  }
}

void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const Params params = random_params(bytes);
  Racer racer(params);
  std::vector<float> ranges;
  for (int step = 0; step < 12 && !bytes.empty(); ++step) {
    if (bytes.take<std::uint8_t>() < 192 || step == 0) random_ranges(bytes, ranges);
    LaserScan scan{-2.356, 4.712 / std::max(1.0, static_cast<double>(ranges.size()) - 1.0), 0.0, 0.02, 30.0, ranges};
    if (bytes.take<std::uint8_t>() < 64) {
      scan.angle_min = bytes.number(-4.0, 4.0);
      scan.angle_increment = bytes.number(-0.05, 0.05);
      scan.time_increment = bytes.number(0.0, 1e-4);
      scan.range_min = bytes.number(0.0, 1.0);
      scan.range_max = bytes.number(0.0, 60.0);
    }
    const VehicleState state{bytes.number(-2.0, 12.0), bytes.number(-8.0, 8.0), bytes.number(-0.5, 0.5)};
    const StepResult result = racer.step(scan, state, bytes.number(0.0, 0.6));
    require(std::isfinite(result.command.speed) && std::isfinite(result.command.steering_angle));
    require(result.command.speed >= 0.0 && result.command.speed <= params.velocity_profile.v_max);
    require(std::abs(result.command.steering_angle) <= params.car.steering_limit);
    require(result.status == Status::ok || result.status == Status::holding || result.status == Status::blocked ||
            result.command.speed == 0.0);
    for (const TrajectoryPoint& p : racer.trace().path)
      require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.curvature));
  }
  return 0;
}
