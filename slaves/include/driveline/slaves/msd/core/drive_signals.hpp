#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/signal.hpp"

/// The signals between a drive and its machine, by name: the terminals (MSD manual Tables 10.6, 10.7), and its supply,
/// cables, shaft, ambient temperature and buttons.
namespace driveline::slaves::msd {

/// Inputs from the machine that are no terminals.
enum class MachineInput : std::uint8_t {
  kDcLink,         ///< volts at the power stage, whatever the mains do
  kMains,          ///< the mains contactor; the DC link then lives on what it has
  kBrakeResistor,  ///< connected
  kMotorShort,     ///< the motor's cables touch each other
  kEncoderCable,   ///< connected
  kAxisBlocked,    ///< the shaft is stuck
  kLoad,           ///< torque on the shaft in Nm, positive pulls in negative direction
  kAmbient,        ///< degrees Celsius
  kButtons,        ///< 1: the two buttons under the display are pressed
  kPositionError,  ///< position units added to 6064h only
  kPositionHeld,   ///< 1: 6064h stays as it is
};

/// Finds a signal of a drive without having a drive.
[[nodiscard]] tl::expected<SignalPlace, SignalNameError> find_drive_signal(SignalPlace::Way way, std::string_view name);
/// Signals of one way; they are numbered from 0. \rtsafe
[[nodiscard]] std::size_t drive_signal_count(SignalPlace::Way way) noexcept;
/// Precondition: place.number < drive_signal_count(place.way). \rtsafe
[[nodiscard]] std::string_view drive_signal_name(SignalPlace place) noexcept;
/// Checks whether the input can take this value.
[[nodiscard]] tl::expected<void, SignalValueError> check_drive_input(std::size_t input, double value);

/// The MachineInput behind an input, if it is one. \rtsafe
[[nodiscard]] std::optional<MachineInput> machine_input(std::size_t input) noexcept;
/// The terminal behind an input, if it is one. \rtsafe
[[nodiscard]] std::optional<Input> input_terminal(std::size_t input) noexcept;
/// The terminal behind an output, if it is one. \rtsafe
[[nodiscard]] std::optional<Output> output_terminal(std::size_t output) noexcept;

/// An input that follows a script, which counts from the drive's first step.
struct ScriptedSignal {
  std::size_t input = 0;  ///< number of a SignalPlace
  Signal signal;          ///< one that jumps, with values that check_drive_input() accepts
};

class DriveCore;

/// The signals of one drive.
class DriveSignals final : public DeviceSignals {
 public:
  /// The drive must outlive this.
  explicit DriveSignals(DriveCore& drive) noexcept : drive_(&drive) {}

  /// See drive_signal_count().
  [[nodiscard]] std::size_t signal_count(Way way) const noexcept override;
  /// See drive_signal_name().
  [[nodiscard]] std::string signal_name(SignalPlace place) const override;
  [[nodiscard]] tl::expected<SignalPlace, SignalNameError> find_signal(Way way, std::string_view name) const override;
  [[nodiscard]] tl::expected<void, SignalValueError> check_signal_value(std::size_t input, double value) const override;
  void set_signal(std::size_t input, double value) noexcept override;
  [[nodiscard]] double signal(SignalPlace place) const noexcept override;

 private:
  DriveCore* drive_;
};

}  // namespace driveline::slaves::msd
