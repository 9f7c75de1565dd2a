#pragma once

#include <chrono>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/msd/core/brake.hpp"
#include "driveline/slaves/msd/core/drive_motion.hpp"
#include "driveline/slaves/msd/core/mode_control.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves::msd {

/// Device control (CiA 402): hardware enable, state machine, mode of operation and brake, and their commands to the
/// motion in each process data cycle.
class DeviceControl {
 public:
  /// All references must outlive this.
  DeviceControl(const ObjectDictionary& dictionary, const Terminals& terminals, DriveMotion& motion) noexcept
      : dictionary_(&dictionary), terminals_(&terminals), motion_(&motion), brake_(dictionary, terminals) {}

  /// Power-on. The brake keeps its state until follow_brake(). \rtsafe
  void reset() noexcept;

  /// \name One process data cycle, in this order
  /// Times are running times of the drive.
  /// @{

  /// Selects the mode in 6060h. \rtsafe
  void select_mode() noexcept;
  /// Steps the state machine. Returns true when the power has just been switched on: the units of the factor group take
  /// effect then.
  /// \rtsafe
  [[nodiscard]] bool step_state(bool dc_link, std::chrono::nanoseconds now) noexcept;
  /// Controls the brake, then commands the motion. \rtsafe
  void order(std::chrono::nanoseconds now) noexcept;
  /// @}

  /// Whether another such cycle would change nothing but what watch_target() finds, until control word, mode, settings,
  /// inputs, DC link or a fault change: operation is enabled, the motion follows cyclic setpoints, the brake rests. To
  /// be called after such a cycle. \rtsafe
  [[nodiscard]] bool steady(bool dc_link, std::chrono::nanoseconds now) const noexcept;
  /// Finds whether the target is reached: the end of order(). \rtsafe
  void watch_target() noexcept { modes_.update_reached(*motion_); }
  /// Runs one control cycle of the homing mode; returns true when homing has failed in it. \rtsafe
  [[nodiscard]] bool step_homing(std::chrono::nanoseconds time_out) noexcept;
  /// Called when the brake's output may have changed. \rtsafe
  void follow_brake(std::chrono::nanoseconds now) noexcept { brake_.follow(now); }

  /// Applies new setpoints in the dictionary to the active mode. \rtsafe
  void apply_setpoints() noexcept;
  /// Prepares new setpoints in the dictionary for the mode that is selected next. \rtsafe
  void prepare_setpoints() noexcept;

  /// Reports a fault; `coast`: no reaction but switching off. \rtsafe
  void fault(bool coast) noexcept { power_.fault(option_codes_now(), coast); }
  /// Acknowledges a fault; returns false when there is none. \rtsafe
  [[nodiscard]] bool acknowledge() noexcept { return power_.acknowledge(); }

  /// Returns the CiA 402 state machine. \rtsafe
  [[nodiscard]] const PowerStateMachine& power() const noexcept { return power_; }
  /// Returns the active mode. \rtsafe
  [[nodiscard]] OperationMode mode() const noexcept { return modes_.mode(); }
  /// Returns the motor brake. \rtsafe
  [[nodiscard]] const Brake& brake() const noexcept { return brake_; }
  /// Whether hardware enable and safe torque off permit torque. \rtsafe
  [[nodiscard]] bool enabled_by_hardware() const noexcept {
    return terminals_->level(Input::kEnpo) && terminals_->level(Input::kIsdsh);
  }

  /// Further inputs of the status word.
  struct StatusFacts {
    bool warning = false;          ///< at least one warning is active
    bool following_error = false;  ///< too large, or the cause of the active fault
  };
  /// Returns the bits of 6041h that change with state, mode, setting or DC link: in a steady() drive they remain.
  /// \rtsafe
  [[nodiscard]] std::uint16_t state_bits(bool dc_link) const noexcept;
  /// Returns the other bits of 6041h, which change with the motion. \rtsafe
  [[nodiscard]] std::uint16_t motion_bits(const StatusFacts& facts) const noexcept;

 private:
  [[nodiscard]] OptionCodes option_codes_now() const noexcept;
  [[nodiscard]] std::int16_t quick_stop_option() const noexcept;
  [[nodiscard]] bool power_ready(bool dc_link) const noexcept;
  [[nodiscard]] bool came_to_rest(std::chrono::nanoseconds now) const noexcept;
  void find_mode_conditions(std::chrono::nanoseconds now, ModeControl::Conditions& conditions) const noexcept;

  const ObjectDictionary* dictionary_;
  const Terminals* terminals_;
  DriveMotion* motion_;
  PowerStateMachine power_;
  ModeControl modes_{*dictionary_};
  Brake brake_;
};

}  // namespace driveline::slaves::msd
