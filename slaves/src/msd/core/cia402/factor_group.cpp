#include "driveline/slaves/msd/core/cia402/factor_group.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint8_t kPositionPolarity = 0x80;
constexpr std::uint8_t kVelocityPolarity = 0x40;

using Wide = Ratio::Wide;  // product of three 32-bit factors

/// Stores a factor in two 32-bit objects; halves both terms until they fit.
void store(ObjectDictionary& dictionary, Ratio factor, Slot<std::uint32_t> numerator,
           Slot<std::uint32_t> divisor) noexcept {
  auto n = static_cast<std::uint64_t>(factor.numerator());
  auto d = static_cast<std::uint64_t>(factor.divisor());
  while (n > 0xFFFFFFFFU || d > 0xFFFFFFFFU) {
    n >>= 1U;
    d >>= 1U;
  }
  dictionary.set(numerator, std::max(static_cast<std::uint32_t>(n), 1U));
  dictionary.set(divisor, std::max(static_cast<std::uint32_t>(d), 1U));
}

constexpr Wide power_of_ten(int exponent) noexcept {
  Wide power = 1;
  for (int i = 0; i < exponent; ++i) power *= 10;
  return power;
}

/// Returns numerator / divisor * 10^exponent; Wide has space for a factor of 10^18 above 64 bits.
Ratio scaled(Wide numerator, Wide divisor, int exponent) noexcept {
  while ((numerator >> 64U) != 0 || (divisor >> 64U) != 0) {
    numerator >>= 1U;
    divisor >>= 1U;
  }
  return exponent >= 0 ? Ratio::of(numerator * power_of_ten(exponent), std::max<Wide>(divisor, 1))
                       : Ratio::of(numerator, divisor * power_of_ten(-exponent));
}

}  // namespace

Scaling factor_group(ObjectDictionary& dictionary, std::uint32_t encoder_increments) noexcept {
  const auto value = [&](Slot<std::uint32_t> v) { return static_cast<Wide>(dictionary.get(v)); };
  const auto notation = [&](Slot<std::int8_t> v) { return int{dictionary.get(v)}; };
  const int velocity_exponent = notation(kValue.velocity_notation) - notation(kValue.position_notation);
  const int acceleration_exponent = notation(kValue.acceleration_notation) - notation(kValue.velocity_notation);
  // gear / feed: motor revolutions per position unit. The encoder resolutions cancel out in the actual movement.
  const Wide revolutions = value(kValue.gear_motor_revolutions) * value(kValue.feed_revolutions);
  const Wide units = value(kValue.gear_shaft_revolutions) * value(kValue.feed);

  const Ratio gear = Ratio::of(revolutions, units);
  const auto factor = [&](Slot<std::uint32_t> increments, Slot<std::uint32_t> per_revolutions, int exponent) {
    return scaled(static_cast<Wide>(gear.numerator()) * value(increments),
                  static_cast<Wide>(gear.divisor()) * value(per_revolutions), exponent);
  };
  store(dictionary, factor(kValue.encoder_increments, kValue.encoder_revolutions, 0), kValue.position_factor_numerator,
        kValue.position_factor_divisor);
  store(dictionary, factor(kValue.velocity_encoder_increments, kValue.velocity_encoder_revolutions, velocity_exponent),
        kValue.velocity_factor_numerator, kValue.velocity_factor_divisor);
  store(dictionary,
        factor(kValue.velocity_encoder_increments, kValue.velocity_encoder_revolutions,
               velocity_exponent + acceleration_exponent),
        kValue.acceleration_factor_numerator, kValue.acceleration_factor_divisor);

  const double radians = 2.0 * std::numbers::pi * gear.value();
  const double velocity = radians * std::pow(10.0, velocity_exponent);
  const auto polarity = dictionary.get(kValue.polarity);
  Scaling scaling;
  scaling.inverted = (polarity & kPositionPolarity) != 0;
  scaling.position_rad = scaling.inverted ? -radians : radians;
  scaling.velocity_rad_s = (polarity & kVelocityPolarity) != 0 ? -velocity : velocity;
  scaling.acceleration_rad_s2 = velocity * std::pow(10.0, acceleration_exponent);
  scaling.increments_per_unit =
      Ratio::of(static_cast<Wide>(gear.numerator()) * encoder_increments, static_cast<Wide>(gear.divisor()));
  scaling.units_per_increment = scaling.increments_per_unit.inverse();
  return scaling;
}

}  // namespace driveline::slaves::msd
