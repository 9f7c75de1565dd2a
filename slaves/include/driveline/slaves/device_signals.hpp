#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

namespace driveline::slaves {

/// Direction and number of a signal. The machine around the device sets the inputs, the device sets the outputs.
struct SignalId {
  /// Direction, seen from the device.
  enum class Direction : std::uint8_t { kInput, kOutput };
  Direction direction = Direction::kInput;  ///< direction; inputs and outputs are numbered separately
  std::size_t number = 0;                   ///< from 0, below signal_count() of this direction
};

/// Why no signal was found for a name.
struct SignalNameError {
  /// Kind of error.
  enum class Fault : std::uint8_t {
    kUnknown,    ///< `known` lists the existing signals
    kAmbiguous,  ///< `known` lists the matching signals
  };
  Fault fault = Fault::kUnknown;                                ///< kind of error
  SignalId::Direction direction = SignalId::Direction::kInput;  ///< direction of the requested signal
  std::string_view owner = "device";                            ///< owner of the signal: "device" or "drive"
  std::vector<std::string> known;                               ///< names that a user may write
};

/// Formats the error as the end of a sentence that starts with the name.
[[nodiscard]] std::string describe(const SignalNameError& error);

/// The entry is a text or a byte string and cannot store a number.
struct SignalIsNoNumber {};

/// The value does not fit the entry's type.
struct SignalBeyondEntry {
  double value;      ///< requested value
  std::size_t bits;  ///< length of the entry
  double lowest;     ///< lowest value that fits
  double highest;    ///< highest value that fits
};

/// The value is neither of the two levels of a terminal.
struct SignalIsNoLevel {
  double value;           ///< requested value
  std::string_view name;  ///< name of the input; static
};

/// The value is outside the input's range.
struct SignalBeyondInput {
  double value;           ///< requested value
  std::string_view name;  ///< name of the input; static
  double lowest;          ///< lowest allowed value
  double highest;         ///< highest allowed value
  std::string_view unit;  ///< unit of the three values; static
};

/// Why an input cannot take a value.
using SignalValueError = std::variant<SignalIsNoNumber, SignalBeyondEntry, SignalIsNoLevel, SignalBeyondInput>;

/// Formats the error as a sentence.
[[nodiscard]] std::string describe(const SignalValueError& error);

/// Named signals between a device and the machine around it, for scripts, tests and users that simulate the machine.
class DeviceSignals {
 public:
  /// Short name for users of this class.
  using Direction = SignalId::Direction;
  virtual ~DeviceSignals() = default;

  /// Returns the number of signals of a direction; they are numbered from 0. \rtsafe
  [[nodiscard]] virtual std::size_t signal_count(Direction direction) const noexcept = 0;
  /// Returns the name of an existing signal; unique within its direction. Not \rtsafe.
  [[nodiscard]] virtual std::string signal_name(SignalId id) const = 0;
  /// Returns the signal with this name.
  [[nodiscard]] virtual tl::expected<SignalId, SignalNameError> find_signal(Direction direction,
                                                                            std::string_view name) const = 0;
  /// Checks whether the input accepts this value.
  [[nodiscard]] virtual tl::expected<void, SignalValueError> check_signal_value(std::size_t input,
                                                                                double value) const = 0;

  /// Sets an input at once. Precondition: check_signal_value() has accepted the value. A script or output that
  /// controlled the input no longer affects it. \rtsafe
  virtual void set_signal(std::size_t input, double value) noexcept = 0;
  /// Returns the current value. \rtsafe
  [[nodiscard]] virtual double signal(SignalId id) const noexcept = 0;
};

}  // namespace driveline::slaves
