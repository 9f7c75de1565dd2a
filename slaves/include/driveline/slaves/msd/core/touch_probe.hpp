#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace driveline::slaves::msd {

/// The touch probe function (MSD manual 14.1): latches positions at edges of two inputs and at the encoder's zero
/// pulse. Positions are in the unit of the objects.
class TouchProbe {
 public:
  /// P 2285. 0 is not described and means off (ours).
  enum class Variant : std::uint16_t { kOff = 0, kCia402 = 1, kBeck2 = 2, kSpecific = 3 };
  /// Latched values, in the order of the objects 60BAh-60BDh.
  enum Value : std::uint8_t { kFirstPositive, kFirstNegative, kSecondPositive, kSecondNegative, kValues };

  /// Sets the current control word 60B8h; to be called before the events of a control cycle. \rtsafe
  void control(Variant variant, std::uint16_t function) noexcept;
  /// Whether control() would change nothing: the manufacturer's variants publish latched values in it. \rtsafe
  [[nodiscard]] bool rests(Variant variant, std::uint16_t function) const noexcept {
    return variant == variant_ && (variant == Variant::kOff || (variant == Variant::kCia402 && function == function_));
  }
  /// Handles an edge of probe 0 (ISD05) or 1 (ISD06). \rtsafe
  void edge(std::size_t probe, bool rising, std::int32_t position) noexcept;
  /// Handles a passage of the encoder's zero pulse. \rtsafe
  [[gnu::cold]] void zero_pulse(std::int32_t position) noexcept;

  [[nodiscard]] std::uint16_t status() const noexcept { return status_; }  ///< 60B9h
  /// Returns the values of 60BAh-60BDh. \rtsafe
  [[nodiscard]] std::int32_t value(Value value) const noexcept { return values_[value]; }

 private:
  static constexpr std::size_t kLatches = 5;  ///< 1+, 1-, 2+, 2-, C
  void control_standard(std::uint16_t function) noexcept;
  void control_vendor(std::uint16_t function) noexcept;
  void latch_standard(std::size_t probe, bool rising, bool from_zero_pulse, std::int32_t position) noexcept;
  void latch_vendor(std::size_t latch, std::int32_t position) noexcept;
  void set_status(unsigned bit, bool on) noexcept;
  [[nodiscard]] bool function_bit(unsigned bit) const noexcept { return (function_ >> bit & 1U) != 0; }

  Variant variant_ = Variant::kOff;
  std::uint16_t function_ = 0;
  std::uint16_t status_ = 0;
  std::array<bool, kLatches> armed_{};
  std::array<std::int32_t, kLatches> latched_{};
  std::array<std::int32_t, kValues> values_{};
};

}  // namespace driveline::slaves::msd
