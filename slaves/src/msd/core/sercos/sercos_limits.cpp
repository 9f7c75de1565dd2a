#include "driveline/slaves/msd/core/sercos/sercos_limits.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/slaves/msd/core/sercos/sercos_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr double kPercent = 1e-2;

/// Returns limits of a direction each: the least of these magnitudes.
SercosRange least(double both, double negative, double positive) noexcept {
  return {-std::max(std::min(both, negative), 0.0), std::max(std::min(both, positive), 0.0)};
}

/// Returns the range as the motor sees it when the operation data have inverted polarity.
SercosRange turned(const SercosRange& range, bool inverted) noexcept {
  return inverted ? SercosRange{-range.highest, -range.lowest} : range;
}

}  // namespace

double torque_unit(const SercosScale& scale, double rated_torque_nm) noexcept {
  return std::abs(scale.torque_nm) > 0.0 ? scale.torque_nm : 1e-3 * rated_torque_nm;
}

SercosRange speed_limits(const ObjectDictionary& dictionary, const Scaling& scaling) noexcept {
  const auto share = [&](Slot<float> slot) { return dictionary.get(slot) * kPercent; };
  const double unit = std::abs(scaling.velocity_rad_s);
  const double rated = share(kSercosValue.speed_share) * dictionary.get(kSercosValue.rated_speed) * kRpm;
  const double negative = std::min(-dictionary.get(kSercosValue.negative_velocity_limit) * unit,
                                   share(kSercosValue.negative_speed_share) * rated);
  const double positive = std::min(dictionary.get(kSercosValue.positive_velocity_limit) * unit,
                                   share(kSercosValue.positive_speed_share) * rated);
  return turned(least(dictionary.get(kSercosValue.velocity_limit) * unit, negative, positive),
                scaling.velocity_rad_s < 0.0);
}

SercosRange torque_limits(const ObjectDictionary& dictionary, double unit_nm, double rated_torque_nm) noexcept {
  const auto share = [&](Slot<float> slot) { return dictionary.get(slot) * kPercent; };
  const double unit = std::abs(unit_nm);
  const double rated = share(kSercosValue.torque_share) * rated_torque_nm;
  const double online = share(kSercosValue.online_torque_share);
  const double negative = std::min(-dictionary.get(kSercosValue.negative_torque_limit) * unit,
                                   std::min(online, share(kSercosValue.negative_torque_share)) * rated);
  const double positive = std::min(dictionary.get(kSercosValue.positive_torque_limit) * unit,
                                   std::min(online, share(kSercosValue.positive_torque_share)) * rated);
  return turned(least(dictionary.get(kSercosValue.torque_limit) * unit, negative, positive), unit_nm < 0.0);
}

double speed_command(const ObjectDictionary& dictionary, const Scaling& scaling) noexcept {
  const double sum = static_cast<double>(dictionary.get(kSercosValue.velocity_command)) +
                     dictionary.get(kSercosValue.additive_velocity);
  const double override = dictionary.get(kSercosValue.speed_override) * kPercent;
  return speed_limits(dictionary, scaling).clamp(sum * override * scaling.velocity_rad_s);
}

double torque_command(const ObjectDictionary& dictionary, double unit_nm, double rated_torque_nm) noexcept {
  const int sum = dictionary.get(kSercosValue.torque_command) + dictionary.get(kSercosValue.additive_torque);
  return torque_limits(dictionary, unit_nm, rated_torque_nm).clamp(sum * unit_nm);
}

}  // namespace driveline::slaves::msd
