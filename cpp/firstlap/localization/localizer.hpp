// Localization on a map from scans and odometry: a particle filter, refined by scan-to-map matching, that detects when
// it is lost. One scan in, one pose out.
#pragma once

#include <cstdint>
#include <tuple>

#include "firstlap/common/car_dynamics.hpp"
#include "firstlap/common/types.hpp"
#include "firstlap/estimation/speed_scale.hpp"
#include "firstlap/localization/likelihood_field.hpp"
#include "firstlap/localization/params.hpp"
#include "firstlap/localization/particle_filter.hpp"
#include "firstlap/mapping/cloud.hpp"
#include "firstlap/perception/scan_period.hpp"

namespace firstlap::localization {

// Pose of base_link in the map's frame at the end of the sweep.
struct Estimate {
  Pose2 pose{};
  double std = 0.0;
  double std_yaw = 0.0;
  double fit = 0.0;
  bool searching = true;
  bool lost = true;
  // From the motion on the map; exactly 1 without a significant error.
  double speed_scale = 1.0;
  double command_scale = 1.0;

  static constexpr auto columns() {
    using C = Estimate;
    return std::tuple{
        Part{&C::pose},
        Column{"std", &C::std, "m", "standard deviation of the particles around the pose"},
        Column{"std_yaw", &C::std_yaw, "rad", "standard deviation of the particles around the pose"},
        Column{"fit", &C::fit, "", "share of the scan that lies on the map"},
        Column{"searching", &C::searching, "", "something does not fit: the filter searches farther around"},
        Column{"lost", &C::lost, "", "the pose must not be trusted: stop"},
        Column{"speed_scale", &C::speed_scale, "", "true speed per measured speed, from the motion on the map"},
        Column{"command_scale", &C::command_scale, "", "true speed per commanded speed, never below 1"},
    };
  }
};

// The pose `time` [s] later at the measured speed and yaw rate, to compensate latency.
Pose2 predicted(const Pose2& pose, const VehicleState& state, const MotionParams& motion, double time) noexcept;

class Localizer {
 public:
  // Throws std::invalid_argument with section, field, value and allowed range. Takes ownership of the field.
  Localizer(LikelihoodField field, const CarModel& car, const LocalizerParams& params, std::uint64_t seed);
  Localizer(const Localizer&) = delete;
  Localizer& operator=(const Localizer&) = delete;

  // Forgets everything. base_link is near `pose` in the map's frame, within filter.start_radius and filter.start_angle.
  void start(const Pose2& pose) noexcept;

  // Shifts all estimates by `by` in base_link, as if the car had been picked up and put down elsewhere. For tests.
  void displace(const Pose2& by) noexcept;

  // The speed command [m/s] given after the last step, for the command scale.
  void commanded(double speed) noexcept;

  // One scan, the state measured at its end, and the time since the previous scan [s]. Never throws, prints, locks,
  // waits or allocates, for any input. Lost until start() is called.
  Estimate step(const LaserScan& scan, const VehicleState& state, double dt) noexcept;

  [[nodiscard]] const Estimate& estimate() const noexcept { return estimate_; }
  [[nodiscard]] const LocalizerParams& params() const noexcept { return params_; }
  [[nodiscard]] std::size_t particles() const noexcept { return filter_.size(); }

 private:
  void move(const VehicleState& state, double dt) noexcept;
  bool choose_beams(const LaserScan& scan, const VehicleState& state) noexcept;
  void locate() noexcept;
  void update_status(const Cluster& cluster, double dt) noexcept;
  void learn_speed_scale(double dt) noexcept;
  void resample() noexcept;

  LikelihoodField field_;
  CarDynamics car_;
  LocalizerParams params_;
  mapping::CloudMaker maker_;
  ParticleFilter filter_;
  Buffer<Beam> beams_, dense_;  // for weighting, for refinement
  Pose2 pose_{};                // in the field's frame
  VehicleState last_{};
  Estimate estimate_{};
  ScanPeriod period_{};                  // of the scans
  SpeedScale speed_scale_{};             // estimate of the speed scale error
  double speed_command_ = 0.0;           // [m/s] last command
  double moved_ = 0.0, measured_ = 0.0;  // [m] assumed and measured forward motion since the last update of the scale
  double missed_ = 0.0;                  // [m] true minus assumed forward motion, from the map
  double tight_fit_ = 0.0, usual_fit_ = 0.0;  // share of the scan very close to walls, now and on average
  int searches_ = 0;
  double average_fit_ = 0.0, good_time_ = 0.0;
  bool started_ = false, moving_ = false, was_found_ = false, jumped_ = false;
};

}  // namespace firstlap::localization
