#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/cia402/words.hpp"

namespace driveline::slaves {

/// States of the CiA 402 power drive, numbered as in MSD manual 10.1.3.
enum class PowerState : std::uint8_t {
  kNotReadyToSwitchOn = 1,
  kSwitchOnDisabled = 2,
  kReadyToSwitchOn = 3,
  kSwitchedOn = 4,
  kOperationEnabled = 5,
  kQuickStopActive = 6,
  kFaultReactionActive = 7,
  kFault = 8,
};

/// Returns bits 0..3, 5 and 6 of the status word (MSD manual Table 11.8; bit 5 is 0 where it is irrelevant).
[[nodiscard]] constexpr std::uint16_t status_bits(PowerState state) noexcept {
  switch (state) {
    case PowerState::kNotReadyToSwitchOn:
      return 0x0000;
    case PowerState::kSwitchOnDisabled:
      return 0x0040;
    case PowerState::kReadyToSwitchOn:
      return 0x0021;
    case PowerState::kSwitchedOn:
      return 0x0023;
    case PowerState::kOperationEnabled:
      return 0x0027;
    case PowerState::kQuickStopActive:
      return 0x0007;
    case PowerState::kFaultReactionActive:
      return 0x000F;
    case PowerState::kFault:
      return 0x0008;
  }
  return 0;
}

/// Command for the motor.
enum class MotionCommand : std::uint8_t {
  kOff,            ///< power stage off, the motor coasts
  kFollow,         ///< follow the setpoints of the mode of operation
  kSlowDownRamp,   ///< decelerate to standstill with 6084h, then hold
  kQuickStopRamp,  ///< decelerate to standstill with 6085h, then hold
  kTorqueLimit,    ///< brake with the maximum torque (current limit; the voltage limit has the same effect here)
};

/// Returns the command for option codes 605Ah and 605Eh: 0 disable, 1 slow down ramp, 2 quick stop ramp, 3 current
/// limit, 4 voltage limit; 605Ah also has 5..8 with the reactions of 1..4. \rtsafe
[[nodiscard]] MotionCommand braking_command(std::int16_t code) noexcept;

/// Option codes 605Ah-605Ch and 605Eh with P 154 (MSD manual Table 10.3).
struct OptionCodes {
  std::int16_t quick_stop = 2;                         ///< 605Ah
  std::int16_t shutdown = 0;                           ///< 605Bh
  std::int16_t disable_operation = 1;                  ///< 605Ch
  std::int16_t fault_reaction = 2;                     ///< 605Eh
  std::chrono::nanoseconds external_reaction_time{0};  ///< P 154, for fault reactions -2 and -1
};

/// CiA 402 state machine with its sixteen transitions. It determines state and motion command; the drive executes the
/// command and reports standstill.
///
/// Decisions where the MSD manual contradicts itself: transition 12 is automatic for quick stop codes 0-4 but not for
/// 5-8 (10.2 against 10.1.3); 06h -> 0Fh passes through Switched on to Operation enabled; bit 4 of the status word
/// indicates the DC link voltage in every state.
class PowerStateMachine {
 public:
  /// Conditions of the drive for transitions.
  struct Conditions {
    std::uint16_t control_word = 0;  ///< 6040h
    bool power_ready = false;        ///< ENPO, ISDSH and the DC link voltage are present
    bool standstill = false;         ///< the motor is at standstill and a ramp, if any, has ended
    OptionCodes options;             ///< current option codes
  };

  /// Evaluates the conditions, `dt` after the previous call. Uses levels only; acknowledge() handles the edge of the
  /// fault reset.
  /// \rtsafe
  void step(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept;
  /// Transition 13. `coast`: the fault allows no reaction but switching off. \rtsafe
  void fault(const OptionCodes& options, bool coast) noexcept;
  /// Transition 15; returns false when the drive is not in Fault. \rtsafe
  bool acknowledge() noexcept;

  /// Returns the state; status_bits() converts it to bits 0-3, 5 and 6 of the status word. \rtsafe
  [[nodiscard]] PowerState state() const noexcept { return state_; }
  /// Returns the command for the motor until the next step(). \rtsafe
  [[nodiscard]] MotionCommand motion() const noexcept { return motion_; }
  /// Whether the motor is under control.
  [[nodiscard]] bool power_on() const noexcept { return motion_ != MotionCommand::kOff; }
  /// Whether the controlled stop in progress ends with the power stage off, with this quick stop option code (605Ah).
  /// \rtsafe
  [[nodiscard]] bool powers_off_at_standstill(std::int16_t quick_stop_code) const noexcept;
  /// Whether a quick stop has ended whose state persists (codes 5-8).
  [[nodiscard]] bool quick_stop_finished() const noexcept { return quick_stop_finished_; }

 private:
  void enter(PowerState state, MotionCommand motion) noexcept;
  void stop_then(PowerState target, MotionCommand motion) noexcept;
  void step_operation_enabled(PowerCommand command, const OptionCodes& options) noexcept;
  void step_quick_stop(PowerCommand command, const Conditions& conditions) noexcept;
  void step_fault_reaction(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept;

  PowerState state_ = PowerState::kNotReadyToSwitchOn;
  MotionCommand motion_ = MotionCommand::kOff;
  PowerState after_stop_ = PowerState::kOperationEnabled;  ///< state after a controlled stop in Operation enabled
  bool stopping_ = false;
  bool quick_stop_finished_ = false;
  std::chrono::nanoseconds external_time_left_{0};
  bool external_ends_at_standstill_ = false;
};

}  // namespace driveline::slaves
