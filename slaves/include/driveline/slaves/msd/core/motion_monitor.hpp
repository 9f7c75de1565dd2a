#pragma once

#include <chrono>
#include <optional>

#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/mode_control.hpp"
#include "driveline/slaves/msd/core/motion.hpp"
#include "driveline/slaves/msd/core/setpoint_rhythm.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Monitors the movement: following error, limit switches, the cycle of the setpoints.
class MotionMonitor {
 public:
  /// Both must outlive this.
  MotionMonitor(const ObjectDictionary& dictionary, const Motion& motion) noexcept
      : dictionary_(&dictionary), motion_(&motion) {}

  /// Power-on. \rtsafe
  void reset() noexcept { following_error_ = false; }

  /// One process data cycle of the following error; true while it is too large for too long. \rtsafe
  [[nodiscard]] bool step_following_error() noexcept;
  /// As step_following_error() has found it. \rtsafe
  [[nodiscard]] bool following_error() const noexcept { return following_error_; }
  /// A limit switch stops movements towards it; away from it the axis is free. Homing uses the switches itself. \rtsafe
  [[nodiscard]] std::optional<Fault> limit_switch(const InputSignals& signals, OperationMode mode) const noexcept;

  /// One control cycle. \rtsafe
  void step_rhythm() noexcept { rhythm_.step(); }
  /// Setpoints have come. \rtsafe
  void setpoints_came() noexcept { rhythm_.sample(motion_->settings().steps_per_setpoint); }
  /// Setpoints will start anew. \rtsafe
  void restart_rhythm() noexcept { rhythm_ = {}; }
  /// Whether setpoints come in another cycle than configured, or the configured cycle is invalid. \rtsafe
  [[nodiscard]] bool wrong_cycle() const noexcept;
  /// The same, while they are followed. Modes with the internal profile generator need no cycle. \rtsafe
  [[nodiscard]] bool follows_wrong_cycle() const noexcept;

 private:
  const ObjectDictionary* dictionary_;
  const Motion* motion_;
  SetpointRhythm rhythm_;
  std::chrono::nanoseconds following_error_time_{0};
  bool following_error_ = false;
};

}  // namespace driveline::slaves::msd
