// Named signals of the drive's terminals and of the machine.
#include "driveline/slaves/msd/core/drive_signals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "driveline/slaves/msd/core/drive_core.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

using Direction = SignalId::Direction;

template <typename Terminal>
struct NamedTerminal {
  std::string_view name;
  Terminal terminal;
};

/// Names of the manual (Tables 10.6, 10.7), which has no name for the STO relay.
constexpr std::array kInputSignals = {
    NamedTerminal<Input>{"ENPO", Input::kEnpo},   NamedTerminal<Input>{"ISDSH", Input::kIsdsh},
    NamedTerminal<Input>{"ISD00", Input::kIsd00}, NamedTerminal<Input>{"ISD01", Input::kIsd01},
    NamedTerminal<Input>{"ISD02", Input::kIsd02}, NamedTerminal<Input>{"ISD03", Input::kIsd03},
    NamedTerminal<Input>{"ISD04", Input::kIsd04}, NamedTerminal<Input>{"ISD05", Input::kIsd05},
    NamedTerminal<Input>{"ISD06", Input::kIsd06}, NamedTerminal<Input>{"ISA00", Input::kIsa00},
    NamedTerminal<Input>{"ISA01", Input::kIsa01},
};
constexpr std::array kOutputSignals = {
    NamedTerminal<Output>{"OSD00", Output::kOsd00}, NamedTerminal<Output>{"OSD01", Output::kOsd01},
    NamedTerminal<Output>{"OSD02", Output::kOsd02}, NamedTerminal<Output>{"BRAKE", Output::kBrake},
    NamedTerminal<Output>{"RELAY", Output::kRelay}, NamedTerminal<Output>{"STO_RELAY", Output::kStoRelay},
};
/// External feed-forward in the oscilloscope of the PC tool (MSD manual 12.4), in rpm and Nm.
constexpr std::array<std::string_view, 2> kScopeVariables = {"nref_Ext", "mref_Ext"};

/// Inputs that follow the terminals in the numbering. Without a unit: 0 or 1.
struct NamedMachineInput {
  std::string_view name;
  MachineInput input;
  std::string_view unit{};
  double lowest = 0.0;
  double highest = 1.0;
};
constexpr std::array kMachineInputs = {
    NamedMachineInput{"DC_LINK", MachineInput::kDcLink, "V", 0.0, 1000.0},
    NamedMachineInput{"MAINS", MachineInput::kMains},
    NamedMachineInput{"BRAKE_RESISTOR", MachineInput::kBrakeResistor},
    NamedMachineInput{"MOTOR_SHORT", MachineInput::kMotorShort},
    NamedMachineInput{"ENCODER_CABLE", MachineInput::kEncoderCable},
    NamedMachineInput{"AXIS_BLOCKED", MachineInput::kAxisBlocked},
    NamedMachineInput{"LOAD", MachineInput::kLoad, "Nm", -100000.0, 100000.0},
    NamedMachineInput{"AMBIENT", MachineInput::kAmbient, "degC", -40.0, 150.0},
    NamedMachineInput{"BUTTONS", MachineInput::kButtons},
    NamedMachineInput{"POSITION_ERROR", MachineInput::kPositionError, "position units", -2147483648.0, 2147483647.0},
    NamedMachineInput{"POSITION_HELD", MachineInput::kPositionHeld},
    NamedMachineInput{"RAM", MachineInput::kRam},
};

}  // namespace

std::size_t drive_signal_count(Direction direction) noexcept {
  return direction == Direction::kInput ? kInputSignals.size() + kMachineInputs.size()
                                        : kOutputSignals.size() + kScopeVariables.size();
}

std::string_view drive_signal_name(SignalId id) noexcept {
  if (id.direction == Direction::kOutput) {
    const std::size_t scope = id.number - kOutputSignals.size();
    return id.number < kOutputSignals.size() ? kOutputSignals[id.number].name : kScopeVariables[scope];
  }
  if (id.number < kInputSignals.size()) return kInputSignals[id.number].name;
  return kMachineInputs[id.number - kInputSignals.size()].name;
}

std::optional<Input> input_terminal(std::size_t input) noexcept {
  return input < kInputSignals.size() ? std::optional(kInputSignals[input].terminal) : std::nullopt;
}

std::optional<MachineInput> machine_input(std::size_t input) noexcept {
  if (input < kInputSignals.size()) return std::nullopt;
  return kMachineInputs[input - kInputSignals.size()].input;
}

std::optional<Output> output_terminal(std::size_t output) noexcept {
  return output < kOutputSignals.size() ? std::optional(kOutputSignals[output].terminal) : std::nullopt;
}

tl::expected<SignalId, SignalNameError> find_drive_signal(Direction direction, std::string_view name) {
  SignalNameError unknown{.direction = direction, .owner = "drive", .known = {}};
  for (std::size_t i = 0; i < drive_signal_count(direction); ++i) {
    const auto known = drive_signal_name({direction, i});
    if (known == name) return SignalId{direction, i};
    unknown.known.emplace_back(known);
  }
  return tl::unexpected(std::move(unknown));
}

tl::expected<void, SignalValueError> check_drive_input(std::size_t input, double value) {
  const auto range = input_terminal(input) ? NamedMachineInput{} : kMachineInputs[input - kInputSignals.size()];
  const bool level = range.unit.empty();
  const bool fits = level ? value == 0.0 || value == 1.0 : value >= range.lowest && value <= range.highest;
  if (fits) return {};
  const auto name = drive_signal_name({Direction::kInput, input});
  if (level) return tl::unexpected(SignalValueError{SignalIsNoLevel{value, name}});
  return tl::unexpected(SignalValueError{SignalBeyondInput{value, name, range.lowest, range.highest, range.unit}});
}

std::size_t DriveSignals::signal_count(Direction direction) const noexcept {
  return drive_signal_count(direction);
}

std::string DriveSignals::signal_name(SignalId id) const {
  return std::string(drive_signal_name(id));
}

tl::expected<SignalId, SignalNameError> DriveSignals::find_signal(Direction direction, std::string_view name) const {
  return find_drive_signal(direction, name);
}

tl::expected<void, SignalValueError> DriveSignals::check_signal_value(std::size_t input, double value) const {
  return check_drive_input(input, value);
}

void DriveSignals::set_signal(std::size_t input, double value) noexcept {
  drive_->release_input(input);
  const auto terminal = input_terminal(input);
  if (!terminal) return drive_->set_machine_input(*machine_input(input), value);
  drive_->set_input(*terminal, value >= 0.5);
}

double DriveSignals::signal(SignalId id) const noexcept {
  if (id.direction == Direction::kOutput) {
    if (const auto terminal = output_terminal(id.number)) return drive_->output(*terminal) ? 1.0 : 0.0;
    return id.number == kOutputSignals.size() ? drive_->external_velocity_rad_s() / kRpm : drive_->external_torque_nm();
  }
  const auto terminal = input_terminal(id.number);
  if (!terminal) return drive_->machine_input_value(*machine_input(id.number));
  return drive_->input(*terminal) ? 1.0 : 0.0;
}

}  // namespace driveline::slaves::msd
