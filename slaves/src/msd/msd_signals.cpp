// The drive's terminals, and the machine around it, by name.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "driveline/slaves/msd/drive_signals.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::slaves::msd {
namespace {

using Way = SignalPlace::Way;

constexpr double kScopeRpm = 2.0 * std::numbers::pi / 60.0;  ///< rad/s

template <typename Terminal>
struct NamedTerminal {
  std::string_view name;
  Terminal terminal;
};

/// Names of the manual (Tables 10.6, 10.7); the STO relay has none there.
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
/// What the oscilloscope of the PC tool shows of feed-forward from outside (MSD manual 12.4): rpm and Nm.
constexpr std::array<std::string_view, 2> kScopeVariables = {"nref_Ext", "mref_Ext"};

/// The inputs behind the terminals. Without a unit: 0 or 1.
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
};

}  // namespace

std::size_t drive_signal_count(Way way) noexcept {
  return way == Way::kInput ? kInputSignals.size() + kMachineInputs.size()
                            : kOutputSignals.size() + kScopeVariables.size();
}

std::string_view drive_signal_name(SignalPlace place) noexcept {
  if (place.way == Way::kOutput) {
    const std::size_t scope = place.number - kOutputSignals.size();
    return place.number < kOutputSignals.size() ? kOutputSignals[place.number].name : kScopeVariables[scope];
  }
  if (place.number < kInputSignals.size()) return kInputSignals[place.number].name;
  return kMachineInputs[place.number - kInputSignals.size()].name;
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

tl::expected<SignalPlace, SignalNameError> find_drive_signal(Way way, std::string_view name) {
  SignalNameError unknown{.way = way, .owner = "drive", .known = {}};
  for (std::size_t i = 0; i < drive_signal_count(way); ++i) {
    const auto known = drive_signal_name({way, i});
    if (known == name) return SignalPlace{way, i};
    unknown.known.emplace_back(known);
  }
  return tl::unexpected(std::move(unknown));
}

tl::expected<void, SignalValueError> check_drive_input(std::size_t input, double value) {
  const auto range = input_terminal(input) ? NamedMachineInput{} : kMachineInputs[input - kInputSignals.size()];
  const bool level = range.unit.empty();
  const bool fits = level ? value == 0.0 || value == 1.0 : value >= range.lowest && value <= range.highest;
  if (fits) return {};
  const auto name = drive_signal_name({Way::kInput, input});
  if (level) return tl::unexpected(SignalValueError{SignalIsNoLevel{value, name}});
  return tl::unexpected(SignalValueError{SignalBeyondInput{value, name, range.lowest, range.highest, range.unit}});
}

std::size_t MsdDrive::signal_count(Way way) const noexcept {
  return drive_signal_count(way);
}

std::string MsdDrive::signal_name(SignalPlace place) const {
  return std::string(drive_signal_name(place));
}

tl::expected<SignalPlace, SignalNameError> MsdDrive::find_signal(Way way, std::string_view name) const {
  return find_drive_signal(way, name);
}

tl::expected<void, SignalValueError> MsdDrive::check_signal_value(std::size_t input, double value) const {
  return check_drive_input(input, value);
}

void MsdDrive::set_signal(std::size_t input, double value) noexcept {
  std::erase_if(parameters_.inputs, [input](const ScriptedSignal& script) { return script.input == input; });
  const auto terminal = input_terminal(input);
  if (!terminal) return set_machine_input(*machine_input(input), value);
  std::erase_if(parameters_.switches, [&](const MachineSwitch& s) { return s.input == *terminal; });
  set_input(*terminal, value >= 0.5);
}

double MsdDrive::signal(SignalPlace place) const noexcept {
  if (place.way == Way::kOutput) {
    if (const auto terminal = output_terminal(place.number)) return output(*terminal) ? 1.0 : 0.0;
    return place.number == kOutputSignals.size() ? motion_.external_velocity_rad_s() / kScopeRpm
                                                 : motion_.external_torque_nm();
  }
  const auto terminal = input_terminal(place.number);
  if (!terminal) return machine_input_value(*machine_input(place.number));
  return terminals_.level(*terminal) ? 1.0 : 0.0;
}

void MsdDrive::set_machine_input(MachineInput input, double value) noexcept {
  const bool on = value >= 0.5;
  switch (input) {
    case MachineInput::kDcLink:
      return set_dc_link_voltage(value);
    case MachineInput::kMains:
      return dc_link_.set_mains(on);
    case MachineInput::kBrakeResistor:
      return dc_link_.set_brake_resistor(on);
    case MachineInput::kMotorShort:
      return motion_.motor().set_short_circuit(on);
    case MachineInput::kEncoderCable:
      return motion_.motor().set_encoder_connected(on);
    case MachineInput::kAxisBlocked:
      return motion_.motor().set_blocked(on);
    case MachineInput::kLoad:
      return motion_.motor().set_load(value);
    case MachineInput::kAmbient:
      return thermal_.set_ambient(value);
    case MachineInput::kButtons:
      if (on) press_buttons();
      return;
    case MachineInput::kPositionError:
      position_error_ = std::llrint(value);
      return;
    case MachineInput::kPositionHeld:
      position_held_ = on;
      return;
  }
}

double MsdDrive::machine_input_value(MachineInput input) const noexcept {
  const ServoMotor& motor = motion_.motor();
  const auto level = [](bool on) { return on ? 1.0 : 0.0; };
  switch (input) {
    case MachineInput::kDcLink:
      return dc_link_.volts();
    case MachineInput::kMains:
      return level(dc_link_.mains());
    case MachineInput::kBrakeResistor:
      return level(dc_link_.brake_resistor());
    case MachineInput::kMotorShort:
      return level(motor.short_circuit());
    case MachineInput::kEncoderCable:
      return level(motor.encoder_connected());
    case MachineInput::kAxisBlocked:
      return level(motor.mechanics().blocked());
    case MachineInput::kLoad:
      return motor.mechanics().load_nm();
    case MachineInput::kAmbient:
      return thermal_.ambient_c();
    case MachineInput::kPositionError:
      return static_cast<double>(position_error_);
    case MachineInput::kPositionHeld:
      return level(position_held_);
    case MachineInput::kButtons:
      break;
  }
  return 0.0;
}

}  // namespace driveline::slaves::msd
