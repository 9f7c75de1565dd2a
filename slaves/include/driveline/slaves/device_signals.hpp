#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

namespace driveline::slaves {

/// A signal of a device, as the device sees it: an input that the machine around it sets, an output that it sets.
struct SignalPlace {
  /// Seen from the device.
  enum class Way : std::uint8_t { kInput, kOutput };
  Way way = Way::kInput;   ///< which of the two numberings `number` belongs to
  std::size_t number = 0;  ///< from 0, below signal_count() of its way
};

/// Why a name is not that of a signal.
struct SignalNameError {
  /// Kind of error.
  enum class Fault : std::uint8_t {
    kUnknown,    ///< `known` are the signals that there are
    kAmbiguous,  ///< `known` are the signals that match
  };
  Fault fault = Fault::kUnknown;                    ///< kind of error
  SignalPlace::Way way = SignalPlace::Way::kInput;  ///< of the signal that was asked for
  std::string_view owner = "device";                ///< whose signal: "device" or "drive"
  std::vector<std::string> known;                   ///< as a user may write them
};

/// The end of a sentence that begins with the name.
[[nodiscard]] std::string describe(const SignalNameError& error);

/// The entry is a text, or bytes, and takes no number.
struct SignalIsNoNumber {};

/// The value does not fit the entry's type.
struct SignalBeyondEntry {
  double value;      ///< the value in question
  std::size_t bits;  ///< of the entry
  double lowest;     ///< that fits
  double highest;    ///< that fits
};

/// The value is not one of the two levels of a terminal.
struct SignalIsNoLevel {
  double value;           ///< the value in question
  std::string_view name;  ///< of the input; static
};

/// The value is out of the input's range.
struct SignalBeyondInput {
  double value;           ///< the value in question
  std::string_view name;  ///< of the input; static
  double lowest;          ///< lowest allowed value
  double highest;         ///< highest allowed value
  std::string_view unit;  ///< of all three; static
};

/// Why an input cannot take a value.
using SignalValueError = std::variant<SignalIsNoNumber, SignalBeyondEntry, SignalIsNoLevel, SignalBeyondInput>;

/// The error as a sentence.
[[nodiscard]] std::string describe(const SignalValueError& error);

/// The signals between a device and the machine around it, by name: for scripts, tests and users who simulate the
/// machine.
class DeviceSignals {
 public:
  /// Short for users of this class.
  using Way = SignalPlace::Way;
  virtual ~DeviceSignals() = default;

  /// Signals are numbered from 0 to this. \rtsafe
  [[nodiscard]] virtual std::size_t signal_count(Way way) const noexcept = 0;
  /// Name of a signal that exists; unique in its way. Not \rtsafe.
  [[nodiscard]] virtual std::string signal_name(SignalPlace place) const = 0;
  /// The signal of this name.
  [[nodiscard]] virtual tl::expected<SignalPlace, SignalNameError> find_signal(Way way,
                                                                               std::string_view name) const = 0;
  /// Checks whether the input can take this value.
  [[nodiscard]] virtual tl::expected<void, SignalValueError> check_signal_value(std::size_t input,
                                                                                double value) const = 0;

  /// Sets an input that check_signal_value() has accepted the value for, now. A script or output that the input
  /// followed until then no longer affects it. \rtsafe
  virtual void set_signal(std::size_t input, double value) noexcept = 0;
  /// The value at present. \rtsafe
  [[nodiscard]] virtual double signal(SignalPlace place) const noexcept = 0;
};

}  // namespace driveline::slaves
