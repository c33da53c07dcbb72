// The complete map-less method: one LiDAR scan in, one command out.
#pragma once

#include "firstlap/common/driver.hpp"
#include "firstlap/drivers/racer_memory.hpp"
#include "firstlap/drivers/racer_params.hpp"
#include "firstlap/drivers/racer_workspace.hpp"
#include "firstlap/drivers/trace.hpp"

namespace firstlap {

class Racer final : public Driver {
 public:
  // Throws std::invalid_argument with field, value and allowed range.
  explicit Racer(const Params& params);

  StepResult step(const LaserScan& scan, const VehicleState& measured, double dt) noexcept override;
  void reset() noexcept override { memory_ = blank_; }

  // Changes the parameters while driving. Throws as the constructor does; then the old ones stay.
  void set_params(const Params& params);
  [[nodiscard]] const Params& params() const noexcept { return params_; }
  // Intermediate results of the last step; valid until the next step.
  [[nodiscard]] const Trace& trace() const noexcept { return trace_; }
  // All state between steps. Future commands depend only on it and the parameters: a racer restored from it behaves
  // identically.
  [[nodiscard]] const RacerMemory& memory() const noexcept { return memory_; }
  void restore(const RacerMemory& memory) noexcept { memory_ = memory; }

 private:
  friend struct RacerProbe;  // for tests: overwrites what must hold no state

  StepResult drive(const LaserScan& scan, const VehicleState& measured, double dt) noexcept;
  Status plan(const LaserScan& scan, const VehicleState& state, double dt) noexcept;
  StepResult drive_blind(double dt) noexcept;
  DriveCommand command(const DriveCommand& wanted, double dt) noexcept;

  Params params_;
  RacerMemory memory_;
  RacerMemory blank_;  // memory before the first scan
  RacerWorkspace work_;
  Trace trace_;
};

}  // namespace firstlap
