#include "driveline/slaves/msd/scaling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "driveline/slaves/msd/msd_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint8_t kPositionPolarity = 0x80;
constexpr std::uint8_t kVelocityPolarity = 0x40;

using Wide = unsigned __int128;  // three 32-bit factors

constexpr Wide greatest_common_divisor(Wide a, Wide b) noexcept {
  while (b != 0) {
    const Wide rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/// resolution * gear / feed as a reduced fraction in two 32-bit objects; halved until both fit.
void store_factor(ObjectDictionary& dictionary, Value increments, Value revolutions, Value numerator,
                  Value divisor) noexcept {
  const auto value = [&](Value v) { return static_cast<Wide>(dictionary.get<std::uint32_t>(v)); };
  Wide n = value(increments) * value(kGearMotorRevolutions) * value(kFeedRevolutions);
  Wide d = value(revolutions) * value(kGearShaftRevolutions) * value(kFeed);
  const Wide common = greatest_common_divisor(n, d);
  n /= common;
  d /= common;
  while (n > 0xFFFFFFFFU || d > 0xFFFFFFFFU) {
    n >>= 1U;
    d >>= 1U;
  }
  dictionary.set(numerator, static_cast<std::uint32_t>(n));
  dictionary.set(divisor, std::max(static_cast<std::uint32_t>(d), 1U));
}

}  // namespace

Scaling Scaling::from(ObjectDictionary& dictionary) noexcept {
  const auto value = [&](Value v) { return static_cast<double>(dictionary.get<std::uint32_t>(v)); };
  store_factor(dictionary, kEncoderIncrements, kEncoderRevolutions, kPositionFactorNumerator, kPositionFactorDivisor);
  store_factor(dictionary, kVelocityEncoderIncrements, kVelocityEncoderRevolutions, kVelocityFactorNumerator,
               kVelocityFactorDivisor);
  dictionary.set(kAccelerationFactorNumerator, dictionary.get<std::uint32_t>(kVelocityFactorNumerator));
  dictionary.set(kAccelerationFactorDivisor, dictionary.get<std::uint32_t>(kVelocityFactorDivisor));

  // One position unit is gear / feed motor revolutions: the encoder resolution cancels out.
  const double revolutions_per_unit =
      value(kGearMotorRevolutions) * value(kFeedRevolutions) / (value(kGearShaftRevolutions) * value(kFeed));
  const double radians = 2.0 * std::numbers::pi * revolutions_per_unit;
  const auto polarity = dictionary.get<std::uint8_t>(kPolarity);
  return {(polarity & kPositionPolarity) != 0 ? -radians : radians,
          (polarity & kVelocityPolarity) != 0 ? -radians : radians, radians};
}

template <typename T>
T saturate(double value) noexcept {
  if (std::isnan(value)) return T{0};
  const auto low = static_cast<double>(std::numeric_limits<T>::min());
  const auto high = static_cast<double>(std::numeric_limits<T>::max());
  if (value <= low) return std::numeric_limits<T>::min();
  if (value >= high) return std::numeric_limits<T>::max();
  return static_cast<T>(std::lrint(value));
}

template std::int16_t saturate<std::int16_t>(double) noexcept;
template std::int32_t saturate<std::int32_t>(double) noexcept;
template std::uint32_t saturate<std::uint32_t>(double) noexcept;

}  // namespace driveline::slaves::msd
