// The drive's terminals and its DC link by name.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "driveline/slaves/msd/drive_signals.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::slaves::msd {
namespace {

using Way = SignalPlace::Way;

template <typename Terminal>
struct NamedTerminal {
  std::string_view name;
  Terminal terminal;
};

/// Names of the manual (Tables 10.6, 10.7); the STO relay has none there.
constexpr std::array kInputs = {
    NamedTerminal<Input>{"ENPO", Input::kEnpo},   NamedTerminal<Input>{"ISDSH", Input::kIsdsh},
    NamedTerminal<Input>{"ISD00", Input::kIsd00}, NamedTerminal<Input>{"ISD01", Input::kIsd01},
    NamedTerminal<Input>{"ISD02", Input::kIsd02}, NamedTerminal<Input>{"ISD03", Input::kIsd03},
    NamedTerminal<Input>{"ISD04", Input::kIsd04}, NamedTerminal<Input>{"ISD05", Input::kIsd05},
    NamedTerminal<Input>{"ISD06", Input::kIsd06}, NamedTerminal<Input>{"ISA00", Input::kIsa00},
    NamedTerminal<Input>{"ISA01", Input::kIsa01},
};
constexpr std::array kOutputs = {
    NamedTerminal<Output>{"OSD00", Output::kOsd00}, NamedTerminal<Output>{"OSD01", Output::kOsd01},
    NamedTerminal<Output>{"OSD02", Output::kOsd02}, NamedTerminal<Output>{"BRAKE", Output::kBrake},
    NamedTerminal<Output>{"RELAY", Output::kRelay}, NamedTerminal<Output>{"STO_RELAY", Output::kStoRelay},
};
constexpr std::string_view kDcLink = "DC_LINK";  ///< the input behind the terminals
constexpr double kMaxVolts = 1000.0;

}  // namespace

std::size_t drive_signal_count(Way way) noexcept {
  return way == Way::kInput ? kInputs.size() + 1 : kOutputs.size();
}

std::string_view drive_signal_name(SignalPlace place) noexcept {
  if (place.way == Way::kOutput) return kOutputs[place.number].name;
  return place.number < kInputs.size() ? kInputs[place.number].name : kDcLink;
}

std::optional<Input> input_terminal(std::size_t input) noexcept {
  return input < kInputs.size() ? std::optional(kInputs[input].terminal) : std::nullopt;
}

Output output_terminal(std::size_t output) noexcept {
  return kOutputs[output].terminal;
}

tl::expected<SignalPlace, std::string> find_drive_signal(Way way, std::string_view name) {
  std::string list;
  for (std::size_t i = 0; i < drive_signal_count(way); ++i) {
    const auto known = drive_signal_name({way, i});
    if (known == name) return SignalPlace{way, i};
    list += fmt::format("{}{}", list.empty() ? "" : ", ", known);
  }
  return tl::unexpected(
      fmt::format("is no {} of the drive; there are {}", way == Way::kInput ? "input" : "output", list));
}

tl::expected<void, std::string> check_drive_input(std::size_t input, double value) {
  const bool terminal = input_terminal(input).has_value();
  const double highest = terminal ? 1.0 : kMaxVolts;
  const bool fits = terminal ? value == 0.0 || value == highest : value >= 0.0 && value <= highest;
  if (fits) return {};
  return tl::unexpected(fmt::format("{} does not fit {}, {} is expected", value,
                                    drive_signal_name({Way::kInput, input}),
                                    terminal ? "0 or 1" : fmt::format("0 to {} V", highest)));
}

std::size_t MsdDrive::signal_count(Way way) const noexcept {
  return drive_signal_count(way);
}

std::string MsdDrive::signal_name(SignalPlace place) const {
  return std::string(drive_signal_name(place));
}

tl::expected<SignalPlace, std::string> MsdDrive::find_signal(Way way, std::string_view name) const {
  return find_drive_signal(way, name);
}

tl::expected<void, std::string> MsdDrive::check_signal_value(std::size_t input, double value) const {
  return check_drive_input(input, value);
}

void MsdDrive::set_signal(std::size_t input, double value) noexcept {
  std::erase_if(parameters_.inputs, [input](const ScriptedSignal& script) { return script.input == input; });
  const auto terminal = input_terminal(input);
  if (!terminal) return set_dc_link_voltage(value);
  std::erase_if(parameters_.switches, [&](const MachineSwitch& s) { return s.input == *terminal; });
  set_input(*terminal, value >= 0.5);
}

double MsdDrive::signal(SignalPlace place) const noexcept {
  if (place.way == Way::kOutput) return output(output_terminal(place.number)) ? 1.0 : 0.0;
  const auto terminal = input_terminal(place.number);
  if (!terminal) return dc_link_volts_;
  return terminals_.level(*terminal) ? 1.0 : 0.0;
}

}  // namespace driveline::slaves::msd
