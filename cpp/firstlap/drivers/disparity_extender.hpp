// The disparity extender (N. Otterness, F1TENTH 2019). Where neighboring ranges differ by a disparity, the nearer one
// is extended over the farther one by half the car's width. The car aims at the farthest remaining direction, as fast
// as the free distance allows, and does not turn toward a side with too little clearance.
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

#include "firstlap/common/buffer.hpp"
#include "firstlap/common/car_geometry.hpp"
#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/reactive_control.hpp"
#include "firstlap/drivers/sweep.hpp"

namespace firstlap::drivers {

struct DisparityParams {
  double view_angle = 1.4;
  double disparity = 0.35;
  double tolerance = 0.3;
  double block_share = 0.97;
  double straight_weight = 0.0;
  double side_clearance = 0.1;
  double emergency_margin = 0.0;

  static constexpr auto fields() {
    using P = DisparityParams;
    return std::tuple{
        Field{"view_angle", &P::view_angle, "rad", 0.3, 2.3, "directions farther to the side are ignored"},
        Field{"disparity", &P::disparity, "m", 0.05, 3.0, "neighboring ranges that differ by more form a disparity"},
        Field{"tolerance", &P::tolerance, "m", 0.0, 1.0, "disparities are extended by half the car's width plus this"},
        Field{"block_share", &P::block_share, "", 0.5, 1.0,
              "the aim is the middle of the block of ranges above this share of the farthest range"},
        Field{"straight_weight", &P::straight_weight, "", 0.0, 1.0,
              "free distance: in the direction of the aim (0) or the minimum of aim and straight ahead (1)"},
        Field{"side_clearance", &P::side_clearance, "m", 0.0, 1.0,
              "no turn toward a side with less clearance than this"},
        Field{"emergency_margin", &P::emergency_margin, "m", 0.0, 0.5,
              "the car stops if its body would come closer than this to returns ahead"},
    };
  }
};

struct DisparityExtenderParams {
  CarGeometry car{};
  SweepParams scan{};
  DisparityParams disparity{};
  SteeringParams steering{};
  SpeedParams speed{};
};

template <class AnyParams, class Visitor>
  requires std::is_same_v<std::remove_cvref_t<AnyParams>, DisparityExtenderParams>
void for_each_section(AnyParams& params, Visitor&& visit) {
  visit("car", params.car);
  visit("scan", params.scan);
  visit("disparity", params.disparity);
  visit("steering", params.steering);
  visit("speed", params.speed);
}

// Throws std::invalid_argument with section, field, value and allowed range.
void validate(const DisparityExtenderParams& params);

class DisparityExtender final : public Driver {
 public:
  // Intermediate results of the last step. Angles in the LiDAR's frame, left positive.
  struct Trace {
    Trace() : ranges(max_points), extended(max_points), disparities(max_points) {}
    Buffer<double> ranges;                       // [m] per beam, right to left, repaired and clipped
    Buffer<double> extended;                     // [m] per beam, after the extension
    Buffer<int> disparities;                     // index of the nearer beam of each disparity
    double first_beam = 0.0;                     // [rad] direction of the first range
    double beam_step = 0.0;                      // [rad] between ranges
    int block_first = 0, block_last = 0;         // first and last beam of the farthest block
    double aim = 0.0;                            // [rad]
    double aim_free = 0.0;                       // [m]
    double straight_free = 0.0;                  // [m]
    double wanted = 0.0;                         // [rad] steering angle before the side clearance is checked
    bool held_left = false, held_right = false;  // no turn to that side: too little clearance
    StepResult result{};

    static constexpr auto columns() {
      using C = Trace;
      constexpr auto block = [](const C& t) { return std::pair{t.block_first, t.block_last}; };
      return std::tuple{
          Column{"ranges", &C::ranges, "m", "per beam, right to left, repaired and clipped"},
          Column{"extended", &C::extended, "m", "per beam, after the extension"},
          Column{"disparities", &C::disparities, "", "index of the nearer beam of each disparity"},
          Column{"first_beam", &C::first_beam, "rad", "direction of the first range, in the LiDAR's frame"},
          Column{"beam_step", &C::beam_step, "rad", "between ranges"},
          Column{"block", block, "", "first and last beam of the farthest block"},
          Column{"aim", &C::aim, "rad", "direction of the aim"},
          Column{"aim_free", &C::aim_free, "m", "free distance in the direction of the aim"},
          Column{"straight_free", &C::straight_free, "m", "free distance straight ahead"},
          Column{"wanted", &C::wanted, "rad", "steering angle before the side clearance is checked"},
          Column{"held_left", &C::held_left, "", "no left turn: too little clearance"},
          Column{"held_right", &C::held_right, "", "no right turn: too little clearance"},
          Column{"result", &C::result, "", "speed, steering angle and status"},
      };
    }
  };

  // Throws std::invalid_argument with section, field, value and allowed range.
  explicit DisparityExtender(const DisparityExtenderParams& params);

  StepResult step(const LaserScan& scan, const VehicleState& state, double dt) noexcept override;
  void reset() noexcept override {
    steering_ = 0.0;
    speed_ = no_command;
    period_ = {};
  }

  [[nodiscard]] const DisparityExtenderParams& params() const noexcept { return params_; }
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }

 private:
  void extend_disparities() noexcept;
  void extend(std::size_t from, int direction) noexcept;
  // Consecutive beams, the last one included.
  struct Block {
    std::size_t first = 0;
    std::size_t last = 0;
  };
  [[nodiscard]] double middle_of(const Block& block) const noexcept;  // [rad]
  [[nodiscard]] bool is_better(const Block& block, const Block& than) const noexcept;
  void choose_block() noexcept;
  double turn_with_clearance(double wanted) noexcept;
  StepResult stop(double dt, Status why) noexcept;

  DisparityExtenderParams params_;
  Sweep sweep_;
  Trace trace_;
  double steering_ = 0.0;      // [rad] last command
  double speed_ = no_command;  // [m/s] last command
  ScanPeriod period_{};
};

}  // namespace firstlap::drivers
