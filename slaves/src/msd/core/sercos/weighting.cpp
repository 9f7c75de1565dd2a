#include "driveline/slaves/msd/core/sercos/weighting.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace driveline::slaves::msd::sercos {
namespace {

using Wide = Ratio::Wide;

// Bits of the types S-0-0044, S-0-0076, S-0-0086 and S-0-0160 (SERCOS manual, Tables 7.4, 7.10, 7.15, 7.19).
constexpr unsigned kMethod = 0x0007;
constexpr unsigned kParameter = 0x0008;  ///< factor and exponent count; otherwise those of the preferred weighting
constexpr unsigned kOtherUnit = 0x0010;  ///< inches, lbf, in lbf
constexpr unsigned kSeconds = 0x0020;    ///< S-0-0044 alone
constexpr unsigned kLoadSide = 0x0040;
constexpr unsigned kModulo = 0x0080;  ///< S-0-0076 alone
constexpr unsigned kUnweighted = 0;
constexpr unsigned kLinear = 1;
constexpr unsigned kRotary = 2;
constexpr unsigned kReservedPosition = 0xFF20;
constexpr unsigned kReservedSpeed = 0xFF80;
constexpr unsigned kReservedAcceleration = 0xFFA0;
constexpr unsigned kReservedTorque = 0xFFA0;

/// Powers of ten that an exponent may name: 128 bits hold the products of all factors (ours).
constexpr int kMinExponent = -15;
constexpr int kMaxExponent = 6;
constexpr int kMaxDecimals = 15;  ///< four bits of the attribute
constexpr std::uint32_t kPreferredResolution = 3600000;
constexpr std::uint64_t kMaxModulo = std::uint64_t{1} << 31U;
constexpr double kInchM = 0.0254;
constexpr double kPoundForceN = 4.4482216152605;

constexpr unsigned method(std::uint16_t type) noexcept {
  return type & kMethod;
}
constexpr bool has(std::uint16_t type, unsigned bits) noexcept {
  return (type & bits) != 0;
}
constexpr bool contradict(std::uint16_t a, std::uint16_t b) noexcept {
  return method(a) != kUnweighted && method(b) != kUnweighted && method(a) != method(b);
}
constexpr bool other_unit_of_rotary(std::uint16_t type) noexcept {
  return method(type) == kRotary && has(type, kOtherUnit);
}
constexpr bool exponent_beyond(std::int16_t exponent) noexcept {
  return exponent < kMinExponent || exponent > kMaxExponent;
}

using Settings = WeightingSettings;

constexpr std::string_view kNoMethod = "the method is neither none, linear nor rotary";
constexpr std::string_view kReservedBit = "a reserved bit is set";
constexpr std::string_view kReservedUnit = "the unit is reserved";
constexpr std::string_view kZero = "it is 0";
constexpr std::string_view kExponent = "the exponent is not from -15 to 6";
constexpr std::string_view kUnlikePosition = "one is linear and the other rotary: this and the position, S-0-0076";

/// Reserved bits and units: SERCOS manual 1118-1136, 1158-1173, 1215-1233, 1244-1256, 1297-1313, 1361-1377, 1388-1400.
/// Contradictions, zeros and limits are ours.
constexpr std::array kRules = {
    WeightingRule{76, kNoMethod, [](const Settings& s) noexcept { return method(s.position_type) > kRotary; }},
    WeightingRule{76, kReservedBit, [](const Settings& s) noexcept { return has(s.position_type, kReservedPosition); }},
    WeightingRule{76, kReservedUnit, [](const Settings& s) noexcept { return other_unit_of_rotary(s.position_type); }},
    WeightingRule{77, kZero, [](const Settings& s) noexcept { return s.position_factor == 0; }},
    WeightingRule{78, kExponent, [](const Settings& s) noexcept { return exponent_beyond(s.position_exponent); }},
    WeightingRule{79, kZero, [](const Settings& s) noexcept { return s.rotary_resolution == 0; }},
    WeightingRule{44, kNoMethod, [](const Settings& s) noexcept { return method(s.speed_type) > kRotary; }},
    WeightingRule{44, kReservedBit, [](const Settings& s) noexcept { return has(s.speed_type, kReservedSpeed); }},
    WeightingRule{44, kReservedUnit, [](const Settings& s) noexcept { return other_unit_of_rotary(s.speed_type); }},
    WeightingRule{44, kUnlikePosition,
                  [](const Settings& s) noexcept { return contradict(s.speed_type, s.position_type); }},
    WeightingRule{45, kZero, [](const Settings& s) noexcept { return s.speed_factor == 0; }},
    WeightingRule{46, kExponent, [](const Settings& s) noexcept { return exponent_beyond(s.speed_exponent); }},
    WeightingRule{160, kNoMethod, [](const Settings& s) noexcept { return method(s.acceleration_type) > kRotary; }},
    WeightingRule{160, kReservedBit,
                  [](const Settings& s) noexcept { return has(s.acceleration_type, kReservedAcceleration); }},
    WeightingRule{160, kReservedUnit,
                  [](const Settings& s) noexcept { return other_unit_of_rotary(s.acceleration_type); }},
    WeightingRule{160, kUnlikePosition,
                  [](const Settings& s) noexcept { return contradict(s.acceleration_type, s.position_type); }},
    WeightingRule{161, kZero, [](const Settings& s) noexcept { return s.acceleration_factor == 0; }},
    WeightingRule{162, kExponent, [](const Settings& s) noexcept { return exponent_beyond(s.acceleration_exponent); }},
    WeightingRule{86, kNoMethod, [](const Settings& s) noexcept { return method(s.torque_type) > kRotary; }},
    WeightingRule{86, kReservedBit, [](const Settings& s) noexcept { return has(s.torque_type, kReservedTorque); }},
    WeightingRule{93, kZero, [](const Settings& s) noexcept { return s.torque_factor == 0; }},
    WeightingRule{94, kExponent, [](const Settings& s) noexcept { return exponent_beyond(s.torque_exponent); }},
    WeightingRule{208, kReservedBit, [](const Settings& s) noexcept { return s.temperature_type != 0; }},
    WeightingRule{43, kReservedBit, [](const Settings& s) noexcept { return has(s.speed_polarity, 0xFFF0); }},
    WeightingRule{55, kReservedBit, [](const Settings& s) noexcept { return has(s.position_polarity, 0xFFE0); }},
    WeightingRule{85, kReservedBit, [](const Settings& s) noexcept { return has(s.torque_polarity, 0xFFF8); }},
    WeightingRule{103, "the modulo value times its divisor (S-0-0294) is not from 1 to 2147483648",
                  [](const Settings& s) noexcept {
                    const std::uint64_t range = std::uint64_t{s.modulo} * s.modulo_divisor;
                    return has(s.position_type, kModulo) && (range == 0 || range > kMaxModulo);
                  }},
    WeightingRule{121, kZero, [](const Settings& s) noexcept { return s.gear_input == 0; }},
    WeightingRule{122, kZero, [](const Settings& s) noexcept { return s.gear_output == 0; }},
    WeightingRule{123, kZero, [](const Settings& s) noexcept { return s.feed_um == 0; }},
};

constexpr Wide power_of_ten(int exponent) noexcept {
  Wide power = 1;
  for (int i = 0; i < exponent; ++i) power *= 10;
  return power;
}

/// A positive fraction before reduction.
struct Fraction {
  Wide numerator = 1;
  Wide divisor = 1;
  [[nodiscard]] double value() const noexcept { return static_cast<double>(numerator) / static_cast<double>(divisor); }
};

/// A weighting by factor and exponent: those of the parameters, or the preferred ones.
struct Lsb {
  Wide factor;
  int exponent;
  [[nodiscard]] double value() const noexcept {
    const double power = static_cast<double>(power_of_ten(std::abs(exponent)));
    return exponent < 0 ? static_cast<double>(factor) / power : static_cast<double>(factor) * power;
  }
};

Lsb lsb(std::uint16_t type, std::uint16_t factor, std::int16_t exponent, int preferred_exponent) noexcept {
  if (!has(type, kParameter)) return {1, preferred_exponent};
  return {factor, std::clamp<int>(exponent, kMinExponent, kMaxExponent)};
}

/// Revolutions of the motor per revolution of the side on which the data are.
Fraction gear(std::uint16_t type, const Settings& s) noexcept {
  if (!has(type, kLoadSide)) return {};
  return {s.gear_input, std::max(s.gear_output, 1U)};
}

double feed_m(const Settings& s) noexcept {
  return std::max(s.feed_um, 1U) * 1e-6;
}

std::uint32_t resolution(const Settings& s) noexcept {
  return has(s.position_type, kParameter) ? std::max(s.rotary_resolution, 1U) : kPreferredResolution;
}

Lsb position_lsb(const Settings& s) noexcept {
  return lsb(s.position_type, s.position_factor, s.position_exponent, -7);
}

/// Increments of the motor encoder per position unit. The largest products have 127 bits.
Fraction increments_per_unit(const Settings& s, std::uint32_t encoder_increments) noexcept {
  const Fraction turns = gear(s.position_type, s);
  Fraction result{turns.numerator * encoder_increments, turns.divisor};
  if (method(s.position_type) == kLinear) {
    const Lsb metres = position_lsb(s);
    const bool inch = has(s.position_type, kOtherUnit);  // 127 / 5000 m
    result.numerator *= metres.factor * 1000000 * (inch ? 127U : 1U) * power_of_ten(metres.exponent);
    result.divisor *= std::max(s.feed_um, 1U) * Wide{inch ? 5000U : 1U} * power_of_ten(-metres.exponent);
    return result;
  }
  if (method(s.position_type) == kRotary) {
    result.divisor *= resolution(s);
    return result;
  }
  return {};
}

/// A display that is exact: `factor` with decimals; what does not fit into them is a power of ten in the text.
WeightedUnit displayed(Lsb lsb, std::string_view text) noexcept {
  WeightedUnit unit;
  const int decimals = std::clamp(-lsb.exponent, 0, kMaxDecimals);
  unit.decimals = static_cast<std::uint8_t>(decimals);
  unit.conversion_factor = static_cast<std::uint16_t>(lsb.factor);
  int rest = lsb.exponent + decimals;
  for (; rest > 0 && unit.conversion_factor <= std::numeric_limits<std::uint16_t>::max() / 10; --rest) {
    unit.conversion_factor = static_cast<std::uint16_t>(unit.conversion_factor * 10);
  }
  if (rest == 0) {
    unit.text = UnitText(text);
  } else {
    const std::array<char, 6> power = {'1', '0', '^', static_cast<char>('0' + rest), ' ', '\0'};
    unit.text = UnitText(std::string_view(power.data(), 5), text);
  }
  return unit;
}

/// Degrees where 360 / resolution is a decimal number of the attribute's size, otherwise parts of a revolution.
WeightedUnit displayed_angle(std::uint32_t resolution) noexcept {
  const std::uint32_t common = std::gcd(360U, resolution);
  const std::uint64_t divisor = resolution / common;
  WeightedUnit unit;
  std::uint64_t power = 1;
  for (int decimals = 0; decimals <= kMaxDecimals; ++decimals, power *= 10) {
    const std::uint64_t factor = 360 / common * (power / divisor);
    if (power % divisor != 0 || factor > std::numeric_limits<std::uint16_t>::max()) continue;
    unit.conversion_factor = static_cast<std::uint16_t>(factor);
    unit.decimals = static_cast<std::uint8_t>(decimals);
    unit.text = UnitText("deg");
    return unit;
  }
  std::array<char, 10> digits{};
  const auto* end = std::to_chars(digits.data(), digits.data() + digits.size(), resolution).ptr;
  unit.text = UnitText("rev/", {digits.data(), static_cast<std::size_t>(end - digits.data())});
  return unit;
}

WeightedUnit plain(std::string_view text, double si) noexcept {
  WeightedUnit unit;
  unit.text = UnitText(text);
  unit.si = si;
  return unit;
}

WeightedUnit position_unit(const Settings& s, double increment_rad) noexcept {
  const bool inch = has(s.position_type, kOtherUnit);
  if (method(s.position_type) == kUnweighted) return plain("incr", increment_rad);
  if (method(s.position_type) == kRotary) {
    WeightedUnit unit = displayed_angle(resolution(s));
    unit.si = 2.0 * std::numbers::pi / resolution(s);
    return unit;
  }
  const Lsb metres = position_lsb(s);
  WeightedUnit unit = displayed(metres, inch ? "in" : "m");
  unit.si = metres.value() * (inch ? kInchM : 1.0);
  return unit;
}

/// Preferred: 0.001 mm/min, 0.0001 1/min, 0.000 001 1/s (SERCOS manual 1197, 1210, 1211).
WeightedUnit speed_unit(const Settings& s, double increment_rad) noexcept {
  const bool seconds = has(s.speed_type, kSeconds);
  const bool inch = has(s.speed_type, kOtherUnit);
  const double time_s = seconds ? 1.0 : 60.0;
  if (method(s.speed_type) == kUnweighted) return plain("incr/s", increment_rad);
  const bool rotary = method(s.speed_type) == kRotary;
  const Lsb value = lsb(s.speed_type, s.speed_factor, s.speed_exponent, rotary && !seconds ? -4 : -6);
  if (rotary) {
    WeightedUnit unit = displayed(value, seconds ? "1/s" : "1/min");
    unit.si = value.value() * 2.0 * std::numbers::pi / time_s;
    return unit;
  }
  WeightedUnit unit = displayed(value, inch ? (seconds ? "in/s" : "in/min") : (seconds ? "m/s" : "m/min"));
  unit.si = value.value() * (inch ? kInchM : 1.0) / time_s;
  return unit;
}

/// Preferred: 0.001 mm/s2, 0.001 rad/s2 (SERCOS manual 1281, 1293).
WeightedUnit acceleration_unit(const Settings& s, double increment_rad) noexcept {
  if (method(s.acceleration_type) == kUnweighted) return plain("incr/s2", increment_rad);
  const bool rotary = method(s.acceleration_type) == kRotary;
  const bool inch = has(s.acceleration_type, kOtherUnit);
  const Lsb value = lsb(s.acceleration_type, s.acceleration_factor, s.acceleration_exponent, rotary ? -3 : -6);
  WeightedUnit unit = displayed(value, rotary ? "rad/s2" : inch ? "in/s2" : "m/s2");
  unit.si = value.value() * (!rotary && inch ? kInchM : 1.0);
  return unit;
}

/// Preferred: 1 N, 0.01 Nm; without a method, 0.1 % of the rated torque (SERCOS manual 1333, 1345, 1357).
WeightedUnit torque_unit(const Settings& s, const WeightedMotor& motor) noexcept {
  const bool pounds = has(s.torque_type, kOtherUnit);
  if (method(s.torque_type) == kUnweighted) {
    WeightedUnit unit = displayed({1, -1}, "%");
    unit.si = 1e-3 * motor.rated_torque_nm;
    return unit;
  }
  const bool rotary = method(s.torque_type) == kRotary;
  const Lsb value = lsb(s.torque_type, s.torque_factor, s.torque_exponent, rotary ? -2 : 0);
  WeightedUnit unit = displayed(value, rotary ? (pounds ? "in lbf" : "Nm") : (pounds ? "lbf" : "N"));
  unit.si = value.value() * (pounds ? kPoundForceN * (rotary ? kInchM : 1.0) : 1.0);
  return unit;
}

/// Motor radians per radian or metre of the data, when they have a method.
double motor_per_si(std::uint16_t type, const Settings& s) noexcept {
  if (method(type) == kUnweighted) return 1.0;
  const double turns = gear(type, s).value();
  return method(type) == kLinear ? turns * 2.0 * std::numbers::pi / feed_m(s) : turns;
}

std::uint16_t inverted_bits(const Settings& s) noexcept {
  const auto bits = [](std::uint16_t word, Polarity first, unsigned mask) {
    return (word & mask) << static_cast<unsigned>(first);
  };
  return static_cast<std::uint16_t>(bits(s.position_polarity, Polarity::kPositionSetpoint, 0x1F) |
                                    bits(s.speed_polarity, Polarity::kSpeedSetpoint, 0x0F) |
                                    bits(s.torque_polarity, Polarity::kTorqueSetpoint, 0x07));
}

PositionRangeLimit modulo_range(const Settings& s) noexcept {
  const std::uint64_t size = std::min(std::uint64_t{s.modulo} * s.modulo_divisor, kMaxModulo);
  if (!has(s.position_type, kModulo) || size == 0) return {};
  return {0, static_cast<std::int32_t>(size - 1)};
}

}  // namespace

std::span<const WeightingRule> weighting_rules() noexcept {
  return kRules;
}

bool exact(const WeightingSettings& settings, const WeightedMotor& motor) noexcept {
  const Fraction wanted = increments_per_unit(settings, motor.encoder_increments);
  Wide a = wanted.numerator;
  Wide b = wanted.divisor;
  while (b != 0) a = std::exchange(b, a % b);
  constexpr Wide kMax = std::numeric_limits<std::int64_t>::max();
  return a != 0 && wanted.numerator / a <= kMax && wanted.divisor / a <= kMax;
}

bool valid(const WeightingSettings& settings, const WeightedMotor& motor) noexcept {
  return std::none_of(kRules.begin(), kRules.end(), [&](const auto& rule) { return rule.broken(settings); }) &&
         exact(settings, motor);
}

Weighting::Weighting(const WeightingSettings& settings, const WeightedMotor& motor) noexcept
    : range_(modulo_range(settings)), inverted_(inverted_bits(settings)) {
  const double increment_rad = 2.0 * std::numbers::pi / std::max(motor.encoder_increments, 1U);
  units_ = {position_unit(settings, increment_rad), speed_unit(settings, increment_rad),
            acceleration_unit(settings, increment_rad), torque_unit(settings, motor), displayed({1, -1}, "degC")};
  units_.back().si = 0.1;
  const auto put = [this](WeightedData data, std::uint16_t type) {
    if (method(type) == kUnweighted) {
      unweighted_ = static_cast<std::uint8_t>(unweighted_ | 1U << static_cast<unsigned>(data));
    }
  };
  put(WeightedData::kPosition, settings.position_type);
  put(WeightedData::kSpeed, settings.speed_type);
  put(WeightedData::kAcceleration, settings.acceleration_type);
  const Fraction increments = increments_per_unit(settings, motor.encoder_increments);
  scaling_.increments_per_unit = Ratio::of(increments.numerator, increments.divisor);
  scaling_.units_per_increment = scaling_.increments_per_unit.inverse();
  scaling_.position_rad = increment_rad * increments.value();
  scaling_.velocity_rad_s = unit(WeightedData::kSpeed).si * motor_per_si(settings.speed_type, settings);
  scaling_.acceleration_rad_s2 =
      unit(WeightedData::kAcceleration).si * motor_per_si(settings.acceleration_type, settings);
  // The power is the same on both sides, so torques and forces convert by the inverse ratio.
  motor_torque_nm_ = unit(WeightedData::kTorque).si / motor_per_si(settings.torque_type, settings);
}

}  // namespace driveline::slaves::msd::sercos
