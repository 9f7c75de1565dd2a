#include "driveline/slaves/msd/core/sercos/sercos_states.hpp"

#include <utility>

#include "driveline/slaves/msd/core/sercos/sercos_words.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::int16_t kAsQuickStop = -1;      ///< P 2219: as P 2218 says
constexpr std::int16_t kUntilStandstill = -1;  ///< P 2222: the master stops the axis

/// Returns the stop of P 2219, which has the values of 605Bh (lines 2057, 425).
MotionCommand switch_off(const OptionCodes& options) noexcept {
  if (options.shutdown == kAsQuickStop) return braking_command(options.quick_stop);
  return options.shutdown == 1 ? MotionCommand::kSlowDownRamp : MotionCommand::kOff;
}

}  // namespace

void SercosStates::enter(PowerState state, MotionCommand command) noexcept {
  state_ = state;
  command_ = command;
}

/// State 4 or 5. A stop that has begun ends with the power stage off, even if bit 15 rises meanwhile (ours).
void SercosStates::step_enabled(const Conditions& conditions, bool on) noexcept {
  if (powers_off_at_standstill()) {
    if (conditions.standstill) enter(PowerState::kReadyToSwitchOn, MotionCommand::kOff);
    return;
  }
  if (on) {
    if (state_ == PowerState::kSwitchedOn && conditions.in_place) enter(PowerState::kOperationEnabled, command_);
    return;
  }
  const MotionCommand stop = switch_off(conditions.options);
  // State 4 has nothing to stop: the axis is torque-free by its status.
  const bool at_once = stop == MotionCommand::kOff || state_ == PowerState::kSwitchedOn;
  if (at_once) return enter(PowerState::kReadyToSwitchOn, MotionCommand::kOff);
  command_ = stop;
}

void SercosStates::step_fault_reaction(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept {
  bool finished = command_ == MotionCommand::kOff || conditions.standstill;
  if (command_ == MotionCommand::kFollow) {  // the master stops the axis (P 2222 = -2, -1)
    external_time_left_ -= dt;
    finished = external_time_left_.count() <= 0 || (external_ends_at_standstill_ && conditions.standstill);
  }
  if (finished || !conditions.power_ready) enter(PowerState::kFault, MotionCommand::kOff);
}

void SercosStates::step(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept {
  const bool enabled = (conditions.control_word & master_control::kEnable) != 0;
  const bool on = (conditions.control_word & master_control::kOn) != 0;
  const bool was_on = std::exchange(was_on_, on);
  switch (state_) {
    case PowerState::kNotReadyToSwitchOn:
      return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
    case PowerState::kFaultReactionActive:
      return step_fault_reaction(conditions, dt);
    case PowerState::kFault:
      return;
    default:
      break;
  }
  if (!enabled || !conditions.power_ready) return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
  if (state_ == PowerState::kSwitchOnDisabled) return enter(PowerState::kReadyToSwitchOn, MotionCommand::kOff);
  if (state_ != PowerState::kReadyToSwitchOn) return step_enabled(conditions, on);
  if (on && (!was_on || conditions.control == Control::kLevel)) enter(PowerState::kSwitchedOn, MotionCommand::kFollow);
}

void SercosStates::fault(const OptionCodes& options, bool coast) noexcept {
  if (state_ == PowerState::kFault) return;
  if (state_ == PowerState::kFaultReactionActive) {  // a second fault continues the reaction of the first
    if (coast) command_ = MotionCommand::kOff;
    return;
  }
  const bool was_on = command_ != MotionCommand::kOff;
  enter(PowerState::kFaultReactionActive, MotionCommand::kOff);
  if (!was_on || coast) return;
  if (options.fault_reaction >= 0) {
    command_ = braking_command(options.fault_reaction);
    return;
  }
  command_ = MotionCommand::kFollow;
  external_time_left_ = options.external_reaction_time;
  external_ends_at_standstill_ = options.fault_reaction == kUntilStandstill;
}

bool SercosStates::acknowledge() noexcept {
  if (state_ != PowerState::kFault) return false;
  enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
  return true;
}

}  // namespace driveline::slaves::msd
