#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::slaves {

/// A signal of a device, as the device sees it: an input that the machine around it sets, an output that it sets.
struct SignalPlace {
  /// Seen from the device.
  enum class Way : std::uint8_t { kInput, kOutput };
  Way way = Way::kInput;   ///< which of the two numberings `number` belongs to
  std::size_t number = 0;  ///< from 0, below signal_count() of its way
};

/// The signals between a device and the machine around it, by name: for scripts, tests and users who play the machine.
class DeviceSignals {
 public:
  /// Short for users of this class.
  using Way = SignalPlace::Way;
  virtual ~DeviceSignals() = default;

  /// Signals are numbered from 0 to this. \rtsafe
  [[nodiscard]] virtual std::size_t signal_count(Way way) const noexcept = 0;
  /// Name of a signal that exists; unique in its way. Not \rtsafe.
  [[nodiscard]] virtual std::string signal_name(SignalPlace place) const = 0;
  /// The signal of this name. Error: the end of a sentence, with the names that there are.
  [[nodiscard]] virtual tl::expected<SignalPlace, std::string> find_signal(Way way, std::string_view name) const = 0;
  /// Can the input take this value? Error: a sentence.
  [[nodiscard]] virtual tl::expected<void, std::string> check_signal_value(std::size_t input, double value) const = 0;

  /// Sets an input that check_signal_value() has accepted the value for, now. What the input followed until then, a
  /// script or an output, lets go of it. \rtsafe
  virtual void set_signal(std::size_t input, double value) noexcept = 0;
  /// The value at present. \rtsafe
  [[nodiscard]] virtual double signal(SignalPlace place) const noexcept = 0;
};

}  // namespace driveline::slaves
