#pragma once

#include <chrono>
#include <optional>

#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/faults.hpp"
#include "driveline/slaves/msd/core/setpoint_rhythm.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Monitors the motion: following error, limit switches, cycle of the setpoints.
class MotionMonitor {
 public:
  /// Both references must outlive this.
  MotionMonitor(const ObjectDictionary& dictionary, const DriveMotion& motion) noexcept
      : dictionary_(&dictionary), motion_(&motion) {}

  /// Power-on. \rtsafe
  void reset() noexcept { following_error_ = false; }

  /// Runs one process data cycle; returns true while the following error is too large for too long. \rtsafe
  [[nodiscard]] bool step_following_error() noexcept;
  /// Returns the result of the last step_following_error(). \rtsafe
  [[nodiscard]] bool following_error() const noexcept { return following_error_; }
  /// Returns a fault while the axis moves towards an active limit switch; the opposite direction is free. Homing
  /// (`homes`) handles the switches itself. \rtsafe
  [[nodiscard]] std::optional<Fault> limit_switch(const InputSignals& signals, bool homes) const noexcept;

  /// Called when setpoints have arrived, in this control cycle. \rtsafe
  void setpoints_came(std::uint64_t cycle) noexcept { rhythm_.sample(cycle, motion_->settings().steps_per_setpoint); }
  /// Called when the setpoints restart. \rtsafe
  void restart_rhythm(std::uint64_t cycle) noexcept { rhythm_.restart(cycle); }
  /// Whether setpoints arrive in another cycle than configured, or the configured cycle is invalid. \rtsafe
  [[nodiscard]] bool wrong_cycle() const noexcept;
  /// Whether setpoints with wrong_cycle() are followed; the internal profile generator needs no cycle. \rtsafe
  [[nodiscard]] bool follows_wrong_cycle() const noexcept;

 private:
  const ObjectDictionary* dictionary_;
  const DriveMotion* motion_;
  SetpointRhythm rhythm_;
  std::chrono::nanoseconds following_error_time_{0};
  bool following_error_ = false;
};

}  // namespace driveline::slaves::msd
