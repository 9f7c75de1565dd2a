#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "driveline/slaves/cia402/ratio.hpp"
#include "driveline/slaves/msd/core/scaling.hpp"

/// Weighting of SERCOS data (ServoOne SERCOS manual, chapter 7): the physical value of the least significant bit of
/// positions, speeds, accelerations, torques and temperatures, and the values that have inverted sign.
namespace driveline::slaves::msd::sercos {

/// Data with a weighting of their own: POS, SPEED, ACC, TORQUE and TEMP in the unit column of Table 10.1.
enum class WeightedData : std::uint8_t { kPosition, kSpeed, kAcceleration, kTorque, kTemperature };

/// Number of WeightedData.
inline constexpr std::size_t kWeightedData = 5;

/// Values whose sign is inverted separately (S-0-0043, S-0-0055, S-0-0085).
enum class Polarity : std::uint8_t {
  kPositionSetpoint,  ///< S-0-0055 bit 0
  kPositionAdditive,  ///< S-0-0055 bit 1
  kPosition1,         ///< S-0-0055 bit 2
  kPosition2,         ///< S-0-0055 bit 3
  kPositionLimits,    ///< S-0-0055 bit 4
  kSpeedSetpoint,     ///< S-0-0043 bit 0
  kSpeedAdditive,     ///< S-0-0043 bit 1
  kSpeed1,            ///< S-0-0043 bit 2
  kSpeed2,            ///< S-0-0043 bit 3
  kTorqueSetpoint,    ///< S-0-0085 bit 0
  kTorqueAdditive,    ///< S-0-0085 bit 1
  kTorque,            ///< S-0-0085 bit 2
  kNever,             ///< no bit inverts the value
};

/// The settings as their IDNs contain them; the initial values are the defaults of the drive.
struct WeightingSettings {
  std::uint16_t position_type = 2;            ///< S-0-0076
  std::uint16_t position_factor = 1;          ///< S-0-0077
  std::int16_t position_exponent = -7;        ///< S-0-0078
  std::uint32_t rotary_resolution = 3600000;  ///< S-0-0079: position units per revolution
  std::uint32_t modulo = 3600000;             ///< S-0-0103 in position units
  std::uint32_t modulo_divisor = 1;           ///< S-0-0294
  std::uint16_t position_polarity = 0;        ///< S-0-0055
  std::uint16_t speed_type = 2;               ///< S-0-0044
  std::uint16_t speed_factor = 1;             ///< S-0-0045
  std::int16_t speed_exponent = -4;           ///< S-0-0046
  std::uint16_t speed_polarity = 0;           ///< S-0-0043
  std::uint16_t acceleration_type = 2;        ///< S-0-0160
  std::uint16_t acceleration_factor = 1;      ///< S-0-0161
  std::int16_t acceleration_exponent = -3;    ///< S-0-0162
  std::uint16_t torque_type = 0;              ///< S-0-0086
  std::uint16_t torque_factor = 1;            ///< S-0-0093
  std::int16_t torque_exponent = -2;          ///< S-0-0094
  std::uint16_t torque_polarity = 0;          ///< S-0-0085
  std::uint16_t temperature_type = 0;         ///< S-0-0208
  std::uint32_t gear_input = 1;               ///< S-0-0121: revolutions of the motor
  std::uint32_t gear_output = 1;              ///< S-0-0122: revolutions of the load, while the motor makes those
  std::uint32_t feed_um = 10000;              ///< S-0-0123: travel in micrometres per revolution
};

/// The motor behind the weighted values.
struct WeightedMotor {
  std::uint32_t encoder_increments = 1U << 20U;  ///< per revolution, above 0
  double rated_torque_nm = 1.0;                  ///< 100 % of torque (P 460)
};

/// A reason why settings cannot be in force.
struct WeightingRule {
  std::uint16_t idn;                                           ///< number of the S parameter that is wrong
  std::string_view reason;                                     ///< continues "S-0-n: "
  bool (*broken)(const WeightingSettings& settings) noexcept;  ///< whether these settings are wrong
};

/// Returns all rules for settings. A weighting is valid when it breaks none: `Weighting` calculates without further
/// checks, but never divides by zero. \rtsafe
[[nodiscard]] std::span<const WeightingRule> weighting_rules() noexcept;
/// Whether the settings break no rule, and a fraction of 63-bit numbers converts positions to increments of this motor
/// exactly. \rtsafe
[[nodiscard]] bool valid(const WeightingSettings& settings, const WeightedMotor& motor) noexcept;
/// Whether positions convert exactly; without it, gear (S-0-0121, S-0-0122) and resolution do not fit together. \rtsafe
[[nodiscard]] bool exact(const WeightingSettings& settings, const WeightedMotor& motor) noexcept;

/// Text of a unit, at most 24 characters.
class UnitText {
 public:
  /// No text.
  constexpr UnitText() noexcept = default;
  /// `first` and `second`, one after the other; what exceeds the space is cut off. \rtsafe
  constexpr explicit UnitText(std::string_view first, std::string_view second = {}) noexcept {
    for (const auto part : {first, second}) {
      for (const char c : part) {
        if (size_ < text_.size()) text_[size_++] = c;
      }
    }
  }
  /// The text, as long as this lives. \rtsafe
  [[nodiscard]] constexpr std::string_view view() const noexcept { return {text_.data(), size_}; }

 private:
  std::array<char, 24> text_{};
  std::size_t size_ = 0;
};

/// Unit of weighted data. A raw number stands for number * conversion_factor / 10^decimals in the unit of the text, and
/// for number * si in the SI unit: rad or m, rad/s or m/s, rad/s2 or m/s2, Nm or N, and degrees Celsius.
struct WeightedUnit {
  UnitText text;                        ///< for display
  std::uint16_t conversion_factor = 1;  ///< as in the attribute of an IDN
  std::uint8_t decimals = 0;            ///< 0 to 15
  double si = 1.0;                      ///< SI value of the raw number 1, on the side of the data: motor or load
};

/// A weighting in force. Conversions of positions to increments of the motor encoder are exact fractions.
class Weighting {
 public:
  /// The default settings, for a motor with the default encoder.
  Weighting() noexcept : Weighting(WeightingSettings{}, WeightedMotor{}) {}
  /// Settings that are valid(); otherwise the numbers are defined, but mean nothing. \rtsafe
  Weighting(const WeightingSettings& settings, const WeightedMotor& motor) noexcept;

  /// Returns the unit of data. \rtsafe
  [[nodiscard]] const WeightedUnit& unit(WeightedData data) const noexcept {
    return units_[static_cast<std::size_t>(data)];
  }
  /// Whether the data have no weighting: they are increments of the encoder, increments/s and increments/s2, with a
  /// unit text of the user (P 284, P 287, P 290). Percent of torque counts as a weighting. \rtsafe
  [[nodiscard]] bool unweighted(WeightedData data) const noexcept {
    return (unweighted_ & 1U << static_cast<unsigned>(data)) != 0;
  }
  /// Returns the conversion between units and motor shaft for the core. It has no polarity: that of SERCOS applies to
  /// each value separately, where it enters or leaves the drive. \rtsafe
  [[nodiscard]] const Scaling& scaling() const noexcept { return scaling_; }
  /// Torque of the motor in Nm for a raw torque or force of 1. \rtsafe
  [[nodiscard]] double motor_torque_nm() const noexcept { return motor_torque_nm_; }
  /// Returns the SI value of a raw number. \rtsafe
  [[nodiscard]] double to_si(WeightedData data, std::int64_t raw) const noexcept {
    return static_cast<double>(raw) * unit(data).si;
  }
  /// Returns the raw number that is nearest to an SI value, limited to 32 bits. \rtsafe
  [[nodiscard]] std::int32_t from_si(WeightedData data, double si) const noexcept {
    return saturate<std::int32_t>(si / unit(data).si);
  }
  /// Returns the range of positions in the modulo format, from 0 to below S-0-0103 * S-0-0294; otherwise all 32 bits.
  /// \rtsafe
  [[nodiscard]] const PositionRangeLimit& range() const noexcept { return range_; }
  /// Whether the value has inverted sign. \rtsafe
  [[nodiscard]] bool inverted(Polarity polarity) const noexcept {
    return (inverted_ & 1U << static_cast<unsigned>(polarity)) != 0;
  }
  /// Returns the value with the sign of its polarity, in either direction. \rtsafe
  [[nodiscard]] std::int64_t turned(Polarity polarity, std::int64_t value) const noexcept {
    return inverted(polarity) ? -value : value;
  }

 private:
  std::array<WeightedUnit, kWeightedData> units_;
  Scaling scaling_;
  double motor_torque_nm_ = 1.0;
  PositionRangeLimit range_;
  std::uint16_t inverted_ = 0;
  std::uint8_t unweighted_ = 0;
};

}  // namespace driveline::slaves::msd::sercos
