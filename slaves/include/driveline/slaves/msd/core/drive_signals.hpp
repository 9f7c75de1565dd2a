#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"
#include "driveline/slaves/signal.hpp"

/// Named signals between a drive and its machine: the terminals (MSD manual Tables 10.6, 10.7), and supply, cables,
/// shaft, ambient temperature and buttons.
namespace driveline::slaves::msd {

/// Inputs from the machine that are not terminals.
enum class MachineInput : std::uint8_t {
  kDcLink,         ///< forced DC link voltage in V, independent of the mains
  kMains,          ///< mains contactor; when open, the DC link has only its stored energy
  kBrakeResistor,  ///< 1: connected
  kMotorShort,     ///< 1: the motor cables are short-circuited
  kEncoderCable,   ///< 1: connected
  kAxisBlocked,    ///< 1: the shaft is blocked
  kLoad,           ///< torque on the shaft in Nm, positive pulls in negative direction
  kAmbient,        ///< ambient temperature in degrees Celsius
  kButtons,        ///< 1: the two buttons below the display are pressed
  kPositionError,  ///< position units added to 6064h only
  kPositionHeld,   ///< 1: 6064h does not change
  kRam,            ///< 0: a cell of the processor's RAM does not hold its value
};

/// Finds a signal of a drive by name, without a drive instance.
[[nodiscard]] tl::expected<SignalId, SignalNameError> find_drive_signal(SignalId::Direction direction,
                                                                        std::string_view name);
/// Returns the number of signals of a direction; they are numbered from 0. \rtsafe
[[nodiscard]] std::size_t drive_signal_count(SignalId::Direction direction) noexcept;
/// Returns the name of a signal. Precondition: id.number < drive_signal_count(id.direction). \rtsafe
[[nodiscard]] std::string_view drive_signal_name(SignalId id) noexcept;
/// Checks whether the input accepts this value.
[[nodiscard]] tl::expected<void, SignalValueError> check_drive_input(std::size_t input, double value);

/// Returns the MachineInput of an input, nullopt if it is a terminal. \rtsafe
[[nodiscard]] std::optional<MachineInput> machine_input(std::size_t input) noexcept;
/// Returns the terminal of an input, nullopt if it is a MachineInput. \rtsafe
[[nodiscard]] std::optional<Input> input_terminal(std::size_t input) noexcept;
/// Returns the terminal of an output, nullopt if it is none. \rtsafe
[[nodiscard]] std::optional<Output> output_terminal(std::size_t output) noexcept;

/// An input that follows a script; its time starts with the drive's first step.
struct ScriptedSignal {
  std::size_t input = 0;  ///< number of the input, see SignalId
  Signal signal;          ///< changes in jumps, to values that check_drive_input() accepts
};

class DriveCore;

/// Signals of a drive.
class DriveSignals final : public DeviceSignals {
 public:
  /// The drive must outlive this.
  explicit DriveSignals(DriveCore& drive) noexcept : drive_(&drive) {}

  /// See drive_signal_count().
  [[nodiscard]] std::size_t signal_count(Direction direction) const noexcept override;
  /// See drive_signal_name().
  [[nodiscard]] std::string signal_name(SignalId id) const override;
  [[nodiscard]] tl::expected<SignalId, SignalNameError> find_signal(Direction direction,
                                                                    std::string_view name) const override;
  [[nodiscard]] tl::expected<void, SignalValueError> check_signal_value(std::size_t input, double value) const override;
  void set_signal(std::size_t input, double value) noexcept override;
  [[nodiscard]] double signal(SignalId id) const noexcept override;

 private:
  DriveCore* drive_;
};

}  // namespace driveline::slaves::msd
