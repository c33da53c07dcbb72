// Center following: two beams on each side give the distance and direction of the walls, projected ahead; a PID
// controller steers the car to the center between them.
#pragma once

#include <tuple>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/reactive_control.hpp"
#include "firstlap/drivers/sweep.hpp"

namespace firstlap::drivers {

struct CenterParams {
  double side_angle = 1.5707963;
  double ahead_angle = 0.6981317;
  double beam_window = 0.03;
  double side_range = 3.0;
  double preview = 1.2;
  double preview_time = 0.0;
  double k_p = 0.35;
  double k_i = 0.0;
  double k_d = 0.06;
  double error_limit = 1.5;
  double derivative_time = 0.05;
  double arc_margin = 0.05;

  static constexpr auto fields() {
    using P = CenterParams;
    return std::tuple{
        Field{"side_angle", &P::side_angle, "rad", 0.9, 2.2, "angle of the beam to the wall beside the car"},
        Field{"ahead_angle", &P::ahead_angle, "rad", 0.1, 0.85, "angle of the beam to the wall ahead"},
        Field{"beam_window", &P::beam_window, "rad", 0.0, 0.2, "ranges are averaged over this angle to either side"},
        Field{"side_range", &P::side_range, "m", 0.3, 30.0, "lateral distances of walls are limited to this"},
        Field{"preview", &P::preview, "m", 0.0, 5.0, "preview distance ahead of the LiDAR"},
        Field{"preview_time", &P::preview_time, "s", 0.0, 2.0, "additional preview as travel time"},
        Field{"k_p", &P::k_p, "rad/m", 0.0, 5.0, "proportional gain, steering angle per offset from the center"},
        Field{"k_i", &P::k_i, "rad/(m s)", 0.0, 2.0, "integral gain; the integral term is limited to 0.2 rad"},
        Field{"k_d", &P::k_d, "rad s/m", 0.0, 1.0, "derivative gain"},
        Field{"error_limit", &P::error_limit, "m", 0.1, 10.0, "limit of the offset from the center"},
        Field{"derivative_time", &P::derivative_time, "s", 0.0, 0.5,
              "time constant of the derivative's low-pass filter"},
        Field{"arc_margin", &P::arc_margin, "m", 0.0, 0.5,
              "clearance of the body in the computation of the free distance"},
    };
  }
};

struct CenterSteeringParams {
  double steering_time = 0.0;
  double a_y_steer = 8.0;

  static constexpr auto fields() {
    using P = CenterSteeringParams;
    return std::tuple{
        Field{"steering_time", &P::steering_time, "s", 0.0, 0.5,
              "time constant of the low-pass filter of the steering angle"},
        Field{"a_y_steer", &P::a_y_steer, "m/s^2", 0.5, 30.0,
              "the steering angle is limited to this lateral acceleration at the measured speed"},
    };
  }
};

struct CenterPidParams {
  CarGeometry car{};
  SweepParams scan{};
  CenterParams center{};
  CenterSteeringParams steering{};
  SpeedParams speed{};
};

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, CenterPidParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("car", params.car);
  visit("scan", params.scan);
  visit("center", params.center);
  visit("steering", params.steering);
  visit("speed", params.speed);
}

// Throws std::invalid_argument with section, field, value and allowed range.
void validate(const CenterPidParams& params);

// A wall, from two beams.
struct WallEstimate {
  double side = 0.0;
  double ahead = 0.0;
  double angle = 0.0;
  double distance = 0.0;
  double preview = 0.0;

  static constexpr auto columns() {
    using C = WallEstimate;
    return std::tuple{
        Column{"side", &C::side, "m", "range of the beam beside the car"},
        Column{"ahead", &C::ahead, "m", "range of the beam ahead"},
        Column{"angle", &C::angle, "rad", "between the wall and the car's heading; negative: the wall closes in"},
        Column{"distance", &C::distance, "m", "from the LiDAR"},
        Column{"preview", &C::preview, "m", "distance from the wall at the preview point"},
    };
  }
};

// The wall through the end points of two beams on one side, `side` and `ahead` [m] long, at `side_angle` and
// `ahead_angle` from the car's axis. `preview` [m] is the distance ahead of the LiDAR.
WallEstimate estimate_wall(double side, double ahead, const CenterParams& params, double preview) noexcept;

class CenterPid final : public Driver {
 public:
  // Intermediate results of the last step.
  struct Trace {
    Trace() : ranges(max_points) {}
    Buffer<double> ranges;    // [m] per beam, right to left, repaired and clipped
    double first_beam = 0.0;  // [rad] direction of the first range
    double beam_step = 0.0;   // [rad] between ranges
    WallEstimate left{}, right{};
    double error = 0.0;       // [m] lateral position of the center at the preview point, left positive
    double integral = 0.0;    // [rad]
    double derivative = 0.0;  // [m/s]
    double preview = 0.0;     // [m] ahead of the LiDAR
    double p_term = 0.0, i_term = 0.0, d_term = 0.0;  // [rad]
    double free = 0.0;                                // [m] free distance along the arc of the steering angle
    StepResult result{};

    static constexpr auto columns() {
      using C = Trace;
      return std::tuple{
          Column{"ranges", &C::ranges, "m", "per beam, right to left, repaired and clipped"},
          Column{"first_beam", &C::first_beam, "rad", "direction of the first range, in the LiDAR's frame"},
          Column{"beam_step", &C::beam_step, "rad", "between ranges"},
          Column{"left", &C::left, "", "the wall on the left"},
          Column{"right", &C::right, "", "the wall on the right"},
          Column{"error", &C::error, "m", "lateral position of the center at the preview point, left positive"},
          Column{"derivative", &C::derivative, "m/s", "derivative of the error, filtered"},
          Column{"preview", &C::preview, "m", "distance ahead of the LiDAR"},
          Column{"p_term", &C::p_term, "rad", "proportional term of the steering angle"},
          Column{"i_term", &C::i_term, "rad", "integral term of the steering angle"},
          Column{"d_term", &C::d_term, "rad", "derivative term of the steering angle"},
          Column{"free", &C::free, "m", "free distance along the arc of the steering angle"},
          Column{"result", &C::result, "", "speed, steering angle and status"},
      };
    }
  };

  // Throws std::invalid_argument with section, field, value and allowed range.
  explicit CenterPid(const CenterPidParams& params);

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override { memory_ = {}; }

  [[nodiscard]] const CenterPidParams& params() const noexcept { return params_; }
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }

 private:
  struct Memory {
    double steering = 0.0;      // [rad] last command
    double speed = no_command;  // [m/s] last command
    double error = 0.0;         // [m]
    double integral = 0.0;      // [rad]
    double derivative = 0.0;    // [m/s]
    bool initialized = false;   // there is a previous error
    ScanPeriod period{};
  };

  [[nodiscard]] double mean_range(double angle) const noexcept;
  void measure(double speed) noexcept;
  double control(double dt) noexcept;
  StepResult stop(double dt, Status why) noexcept;

  CenterPidParams params_;
  Sweep sweep_;
  Trace trace_;
  Memory memory_;
};

}  // namespace firstlap::drivers
