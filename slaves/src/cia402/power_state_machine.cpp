#include "driveline/slaves/cia402/power_state_machine.hpp"

namespace driveline::slaves {
namespace {

bool stays_in_quick_stop(std::int16_t code) noexcept {
  return code >= 5 && code <= 8;
}

}  // namespace

MotionCommand braking_command(std::int16_t code) noexcept {
  switch (code) {
    case 1:
    case 5:
      return MotionCommand::kSlowDownRamp;
    case 2:
    case 6:
      return MotionCommand::kQuickStopRamp;
    case 3:
    case 4:
    case 7:
    case 8:
      return MotionCommand::kTorqueLimit;
    default:
      return MotionCommand::kOff;
  }
}

void PowerStateMachine::enter(PowerState state, MotionCommand motion) noexcept {
  state_ = state;
  motion_ = motion;
  stopping_ = false;
  quick_stop_finished_ = false;
}

void PowerStateMachine::stop_then(PowerState target, MotionCommand motion) noexcept {
  if (motion == MotionCommand::kOff) return enter(target, MotionCommand::kOff);
  motion_ = motion;
  stopping_ = true;
  after_stop_ = target;
}

bool PowerStateMachine::powers_off_at_standstill(std::int16_t quick_stop_code) const noexcept {
  if (!power_on() || motion_ == MotionCommand::kFollow) return false;
  return stopping_ || state_ == PowerState::kFaultReactionActive ||
         (state_ == PowerState::kQuickStopActive && !stays_in_quick_stop(quick_stop_code));
}

void PowerStateMachine::step_operation_enabled(PowerCommand command, const OptionCodes& options) noexcept {
  switch (command) {
    case PowerCommand::kDisableVoltage:  // transition 9
      return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
    case PowerCommand::kQuickStop:  // transition 11
      return enter(PowerState::kQuickStopActive, braking_command(options.quick_stop));
    case PowerCommand::kShutdown:  // transition 8
      if (stopping_) return;
      return stop_then(PowerState::kReadyToSwitchOn, options.shutdown == -1  ? braking_command(options.quick_stop)
                                                     : options.shutdown == 1 ? MotionCommand::kSlowDownRamp
                                                                             : MotionCommand::kOff);
    case PowerCommand::kSwitchOn:  // transition 5
      if (stopping_) return;
      return stop_then(PowerState::kSwitchedOn,
                       options.disable_operation == 1 ? MotionCommand::kSlowDownRamp : MotionCommand::kOff);
    default:
      return;
  }
}

void PowerStateMachine::step_quick_stop(PowerCommand command, const Conditions& conditions) noexcept {
  const bool stays = stays_in_quick_stop(conditions.options.quick_stop);
  const bool finished = motion_ == MotionCommand::kOff || conditions.standstill;
  if (command == PowerCommand::kDisableVoltage || (finished && !stays)) {  // transition 12
    return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
  }
  quick_stop_finished_ = finished;
  if (command == PowerCommand::kEnableOperation && stays) {  // transition 16
    enter(PowerState::kOperationEnabled, MotionCommand::kFollow);
  }
}

void PowerStateMachine::step_fault_reaction(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept {
  bool finished = motion_ == MotionCommand::kOff || conditions.standstill;
  if (motion_ == MotionCommand::kFollow) {  // the controller stops the axis (605Eh = -2, -1)
    external_time_left_ -= dt;
    finished = external_time_left_.count() <= 0 || (external_ends_at_standstill_ && conditions.standstill);
  }
  if (finished || !conditions.power_ready) enter(PowerState::kFault, MotionCommand::kOff);  // transition 14
}

void PowerStateMachine::step(const Conditions& conditions, std::chrono::nanoseconds dt) noexcept {
  const PowerCommand command = power_command(conditions.control_word);
  if (state_ >= PowerState::kReadyToSwitchOn && state_ <= PowerState::kQuickStopActive && !conditions.power_ready) {
    return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
  }
  if (stopping_ && conditions.standstill) enter(after_stop_, MotionCommand::kOff);
  switch (state_) {
    case PowerState::kNotReadyToSwitchOn:  // transition 1
      return enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
    case PowerState::kSwitchOnDisabled:
      if (command == PowerCommand::kShutdown && conditions.power_ready) {  // transition 2
        enter(PowerState::kReadyToSwitchOn, MotionCommand::kOff);
      }
      return;
    case PowerState::kReadyToSwitchOn:
      if (command == PowerCommand::kSwitchOn || command == PowerCommand::kEnableOperation) {  // transition 3
        enter(PowerState::kSwitchedOn, MotionCommand::kOff);
      } else if (command == PowerCommand::kDisableVoltage || command == PowerCommand::kQuickStop) {  // transition 7
        enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
      }
      return;
    case PowerState::kSwitchedOn:
      if (command == PowerCommand::kEnableOperation) {  // transition 4
        enter(PowerState::kOperationEnabled, MotionCommand::kFollow);
      } else if (command == PowerCommand::kShutdown) {  // transition 6
        enter(PowerState::kReadyToSwitchOn, MotionCommand::kOff);
      } else if (command == PowerCommand::kDisableVoltage || command == PowerCommand::kQuickStop) {  // transition 10
        enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
      }
      return;
    case PowerState::kOperationEnabled:
      return step_operation_enabled(command, conditions.options);
    case PowerState::kQuickStopActive:
      return step_quick_stop(command, conditions);
    case PowerState::kFaultReactionActive:
      return step_fault_reaction(conditions, dt);
    case PowerState::kFault:
      return;
  }
}

void PowerStateMachine::fault(const OptionCodes& options, bool coast) noexcept {
  if (state_ == PowerState::kFault) return;
  if (state_ == PowerState::kFaultReactionActive) {  // a second fault continues the reaction of the first
    if (coast) motion_ = MotionCommand::kOff;
    return;
  }
  const bool was_on = power_on();
  enter(PowerState::kFaultReactionActive, MotionCommand::kOff);
  if (!was_on || coast) return;
  if (options.fault_reaction >= 0) {
    motion_ = braking_command(options.fault_reaction);
    return;
  }
  motion_ = MotionCommand::kFollow;
  external_time_left_ = options.external_reaction_time;
  external_ends_at_standstill_ = options.fault_reaction == -1;
}

bool PowerStateMachine::acknowledge() noexcept {
  if (state_ != PowerState::kFault) return false;
  enter(PowerState::kSwitchOnDisabled, MotionCommand::kOff);
  return true;
}

}  // namespace driveline::slaves
