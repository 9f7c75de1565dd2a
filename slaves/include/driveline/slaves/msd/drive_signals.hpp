#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/msd/terminals.hpp"
#include "driveline/slaves/signal.hpp"

/// The signals between a drive and its machine, by name: the terminals (MSD manual Tables 10.6, 10.7) and DC_LINK, the
/// voltage at the power stage.
namespace driveline::slaves::msd {

/// A signal of a drive, for those who have no drive yet. Error: the end of a sentence, with the names that there are.
[[nodiscard]] tl::expected<SignalPlace, std::string> find_drive_signal(SignalPlace::Way way, std::string_view name);
/// Signals of one way; they are numbered from 0. \rtsafe
[[nodiscard]] std::size_t drive_signal_count(SignalPlace::Way way) noexcept;
/// Precondition: place.number < drive_signal_count(place.way). \rtsafe
[[nodiscard]] std::string_view drive_signal_name(SignalPlace place) noexcept;
/// Can the input take this value: 0 or 1 a terminal, volts DC_LINK? Error: a sentence.
[[nodiscard]] tl::expected<void, std::string> check_drive_input(std::size_t input, double value);

/// The terminal behind an input; nothing for DC_LINK. \rtsafe
[[nodiscard]] std::optional<Input> input_terminal(std::size_t input) noexcept;
/// The terminal behind an output. Precondition: output < drive_signal_count(kOutput). \rtsafe
[[nodiscard]] Output output_terminal(std::size_t output) noexcept;

/// An input that follows a script, which counts from the drive's first step.
struct ScriptedSignal {
  std::size_t input = 0;  ///< number of a SignalPlace
  Signal signal;          ///< one that jumps, with values that check_drive_input() accepts
};

}  // namespace driveline::slaves::msd
