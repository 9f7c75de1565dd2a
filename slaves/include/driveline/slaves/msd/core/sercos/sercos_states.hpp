#pragma once

#include <chrono>
#include <cstdint>

#include "driveline/slaves/cia402/power_state_machine.hpp"

namespace driveline::slaves::msd {

/// State machine of a ServoOne by bits 15 and 14 of S-0-0134 (ServoOne SERCOS manual, 4.3.1 and 4.5). It has the states
/// of PowerState: 1 and 2 are kSwitchOnDisabled, 4 is kSwitchedOn, in which the motor already has torque: the brake
/// opens, and the axis may go to the setpoint of the master. \rtsafe throughout.
///
/// Decisions where the manual contradicts itself: the drive gets ready (2 to 3) by ENPO, ISDSH and bit 14, not by bit
/// 15; it is switched on (3 to 4) by bit 15 (Table 4.4 against Table 4.5). Bit 15 that falls leads to state 3.
class SercosStates {
 public:
  /// How bit 15 switches on (P 144).
  enum class Control : std::uint8_t {
    kEdge = 0,   ///< by its rise in state 3
    kLevel = 1,  ///< whenever it is set
  };

  /// Conditions of one process data cycle.
  struct Conditions {
    std::uint16_t control_word = 0;    ///< S-0-0134; 0 outside phase 4, or without control by SERCOS (P 159)
    bool power_ready = false;          ///< ENPO, ISDSH and the DC link voltage are present
    bool standstill = false;           ///< the motor is at standstill and a ramp, if any, has ended
    bool in_place = true;              ///< the brake is open, and the axis stands where it is to start
    Control control = Control::kEdge;  ///< P 144
    OptionCodes options;               ///< P 2218, P 2219, P 2222 and P 154; P 2220 has no effect
  };

  /// Evaluates the conditions, `dt` after the previous call.
  void step(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept;
  /// Begins the reaction by P 2222; `coast`: the fault allows no reaction but switching off.
  void fault(const OptionCodes& options, bool coast) noexcept;
  /// Leaves state 8; returns false in any other.
  [[nodiscard]] bool acknowledge() noexcept;

  /// Returns the state.
  [[nodiscard]] PowerState state() const noexcept { return state_; }
  /// Returns the command for the motor until the next step().
  [[nodiscard]] MotionCommand command() const noexcept { return command_; }
  /// Whether the drive is in control and no stop is in progress: state 5, modes act.
  [[nodiscard]] bool in_control() const noexcept {
    return state_ == PowerState::kOperationEnabled && command_ == MotionCommand::kFollow;
  }
  /// Whether the modes act: in control, or in a reaction in which the master stops the axis (P 2222 = -2, -1).
  [[nodiscard]] bool acts() const noexcept {
    return command_ == MotionCommand::kFollow && state_ != PowerState::kSwitchedOn;
  }
  /// Whether the controlled stop in progress ends with the power stage off.
  [[nodiscard]] bool powers_off_at_standstill() const noexcept {
    return command_ != MotionCommand::kOff && command_ != MotionCommand::kFollow;
  }

 private:
  void enter(PowerState state, MotionCommand command) noexcept;
  void step_enabled(const Conditions& conditions, bool on) noexcept;
  void step_fault_reaction(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept;

  PowerState state_ = PowerState::kNotReadyToSwitchOn;
  MotionCommand command_ = MotionCommand::kOff;
  bool was_on_ = false;  ///< bit 15 in the last step
  bool external_ends_at_standstill_ = false;
  std::chrono::nanoseconds external_time_left_{0};
};

}  // namespace driveline::slaves::msd
