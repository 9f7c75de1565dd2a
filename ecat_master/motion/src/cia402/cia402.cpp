#include "driveline/motion/cia402/cia402.hpp"

namespace driveline::motion::cia402 {

AxisState decode_state(std::uint16_t status_word) noexcept {
  switch (status_word & 0x4F) {
    case 0x00:
      return AxisState::kNotReadyToSwitchOn;
    case 0x40:
      return AxisState::kSwitchOnDisabled;
    case 0x0F:
      return AxisState::kFaultReactionActive;
    case 0x08:
      return AxisState::kFault;
    default:
      break;
  }
  switch (status_word & 0x6F) {
    case 0x21:
      return AxisState::kReadyToSwitchOn;
    case 0x23:
      return AxisState::kSwitchedOn;
    case 0x27:
      return AxisState::kOperationEnabled;
    case 0x07:
      return AxisState::kQuickStopActive;
    default:
      return AxisState::kUnavailable;
  }
}

std::string_view to_text(AxisState state) noexcept {
  switch (state) {
    case AxisState::kNotReadyToSwitchOn:
      return "Not ready to switch on";
    case AxisState::kSwitchOnDisabled:
      return "Switch on disabled";
    case AxisState::kReadyToSwitchOn:
      return "Ready to switch on";
    case AxisState::kSwitchedOn:
      return "Switched on";
    case AxisState::kOperationEnabled:
      return "Operation enabled";
    case AxisState::kQuickStopActive:
      return "Quick stop active";
    case AxisState::kFaultReactionActive:
      return "Fault reaction active";
    case AxisState::kFault:
      return "Fault";
    case AxisState::kUnavailable:
      break;
  }
  return "Unavailable";
}

std::string_view to_text(Mode mode) noexcept {
  switch (mode) {
    case Mode::kProfilePosition:
      return "pp";
    case Mode::kVelocity:
      return "vl";
    case Mode::kProfileVelocity:
      return "pv";
    case Mode::kHoming:
      return "hm";
    case Mode::kInterpolatedPosition:
      return "ip";
    case Mode::kCyclicPosition:
      return "csp";
    case Mode::kCyclicVelocity:
      return "csv";
    case Mode::kCyclicTorque:
      return "cst";
  }
  return "?";
}

namespace {

std::uint16_t towards_enabled(AxisState state) noexcept {
  switch (state) {
    case AxisState::kSwitchOnDisabled:
      return command::kShutdown;
    case AxisState::kReadyToSwitchOn:
      return command::kSwitchOn;
    case AxisState::kSwitchedOn:
    case AxisState::kOperationEnabled:
      return command::kEnableOperation;
    // Finish the quick stop: it ends in Switch on disabled on its own, or here by Disable voltage.
    default:
      return command::kDisableVoltage;
  }
}

std::uint16_t towards_disabled(AxisState state) noexcept {
  switch (state) {
    case AxisState::kOperationEnabled:
      return command::kSwitchOn;  // Disable operation
    case AxisState::kSwitchedOn:
      return command::kShutdown;
    default:
      return command::kDisableVoltage;
  }
}

std::uint16_t towards_quick_stop(AxisState state) noexcept {
  switch (state) {
    // An axis with missing inputs may still receive outputs and move: brake it rather than let it coast.
    case AxisState::kUnavailable:
    case AxisState::kOperationEnabled:
    case AxisState::kQuickStopActive:
      return command::kQuickStop;
    default:
      return command::kDisableVoltage;
  }
}

}  // namespace

std::uint16_t next_control_word(AxisState state, Goal goal) noexcept {
  switch (goal) {
    case Goal::kEnabled:
      return towards_enabled(state);
    case Goal::kQuickStop:
      return towards_quick_stop(state);
    case Goal::kDisabled:
      break;
  }
  return towards_disabled(state);
}

}  // namespace driveline::motion::cia402
