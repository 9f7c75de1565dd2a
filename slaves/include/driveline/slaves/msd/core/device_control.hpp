#pragma once

#include <chrono>

#include "driveline/slaves/msd/core/brake.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/profile/drive_profile.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Device control: hardware enable and brake around the drive profile, and its commands to the motion in each process
/// data cycle.
class DeviceControl {
 public:
  /// All references must outlive this.
  DeviceControl(ObjectDictionary& dictionary, const Terminals& terminals, DriveMotion& motion,
                ProfileKind profile) noexcept
      : dictionary_(&dictionary),
        terminals_(&terminals),
        motion_(&motion),
        profile_(dictionary, profile),
        brake_(dictionary, terminals) {}

  /// Power-on. The brake keeps its state until follow_brake(). \rtsafe
  void reset() noexcept;

  /// \name One process data cycle, in this order
  /// Times are running times of the drive.
  /// @{

  /// Selects the mode. \rtsafe
  void select_mode() noexcept;
  /// Steps the state machine. Returns true when the power has just been switched on: changed units take effect then.
  /// \rtsafe
  [[nodiscard]] bool step_state(bool dc_link, std::chrono::nanoseconds now) noexcept;
  /// Controls the brake, then commands the motion. \rtsafe
  void order(std::chrono::nanoseconds now) noexcept;
  /// @}

  /// Whether another such cycle would change nothing but what watch_target() finds, until commands, settings, inputs,
  /// DC link or a fault change: operation is enabled, the motion follows cyclic setpoints, the brake rests. To be
  /// called after such a cycle. \rtsafe
  [[nodiscard]] bool steady(bool dc_link, std::chrono::nanoseconds now) const noexcept;
  /// Finds whether the target is reached: the end of order(). \rtsafe
  void watch_target() noexcept { profile_.watch_target(*motion_); }
  /// Runs one control cycle of homing; returns true when homing has failed in it. \rtsafe
  [[nodiscard]] bool step_homing(std::chrono::nanoseconds time_out) noexcept {
    return profile_.step_homing(terminals_->signals(), *motion_, time_out);
  }
  /// Called when the brake's output may have changed. \rtsafe
  void follow_brake(std::chrono::nanoseconds now) noexcept { brake_.follow(now); }

  /// Applies new setpoints in the dictionary to the active mode. \rtsafe
  void apply_setpoints() noexcept;
  /// Prepares new setpoints in the dictionary for the mode that is selected next. \rtsafe
  void prepare_setpoints() noexcept;

  /// Returns the drive profile. \rtsafe
  [[nodiscard]] DriveProfile& profile() noexcept { return profile_; }
  /// Returns the drive profile, read only. \rtsafe
  [[nodiscard]] const DriveProfile& profile() const noexcept { return profile_; }
  /// Returns the motor brake. \rtsafe
  [[nodiscard]] const Brake& brake() const noexcept { return brake_; }
  /// Whether hardware enable and safe torque off permit torque. \rtsafe
  [[nodiscard]] bool enabled_by_hardware() const noexcept {
    return terminals_->level(Input::kEnpo) && terminals_->level(Input::kIsdsh);
  }

 private:
  [[nodiscard]] bool power_ready(bool dc_link) const noexcept;
  [[nodiscard]] bool came_to_rest(std::chrono::nanoseconds now) const noexcept;

  const ObjectDictionary* dictionary_;
  const Terminals* terminals_;
  DriveMotion* motion_;
  DriveProfile profile_;
  Brake brake_;
};

}  // namespace driveline::slaves::msd
