// The whole method: one LiDAR scan in, one command out.
#pragma once

#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/racer_memory.hpp"
#include "firstlap/drivers/racer_params.hpp"
#include "firstlap/drivers/racer_workspace.hpp"
#include "firstlap/drivers/trace.hpp"

namespace firstlap {

class Racer final : public Driver {
 public:
  // Throws std::invalid_argument: field, value, allowed range.
  explicit Racer(const Params& params);

  StepResult step(const LaserScan& scan, const VehicleState& measured, double dt) noexcept override;
  void reset() noexcept override { memory_ = blank_; }

  // Changes the parameters while driving; throws as the constructor and then keeps the old ones.
  void set_params(const Params& params);
  [[nodiscard]] const Params& params() const noexcept { return params_; }
  // What the last step saw and thought; valid until the next one.
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }
  // What it will do depends on this and its parameters alone: another racer that is given it goes on as this one.
  [[nodiscard]] const RacerMemory& memory() const noexcept { return memory_; }
  void restore(const RacerMemory& memory) noexcept { memory_ = memory; }

 private:
  friend struct RacerProbe;  // of the tests: spoils what must hold nothing

  StepResult drive(const LaserScan& scan, const VehicleState& measured, double dt) noexcept;
  StepResult drive_blind(double dt) noexcept;
  DriveCommand command(const DriveCommand& wanted, double dt) noexcept;

  Params params_;
  RacerMemory memory_;
  RacerMemory blank_;  // of a car that has seen nothing
  RacerWorkspace work_;
  Trace trace_;
};

}  // namespace firstlap
