#include "driveline/slaves/msd/core/object_checks.hpp"

#include <tuple>

#include "driveline/slaves/msd/core/drive_values.hpp"
#include "driveline/slaves/msd/core/profile/drive_profile.hpp"
#include "driveline/slaves/msd/core/terminals.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::uint64_t kLinearProfile = 0;  ///< 6086h
constexpr std::uint64_t kJerkLimitedProfile = 3;
constexpr std::uint64_t kUnusedSensor = 5;  ///< P 732: "not used"

/// Parameters of which the first must not exceed the second; the manual does not describe which ones its check covers.
template <typename T>
struct InOrder {
  Slot<T> low;
  Slot<T> high;

  [[nodiscard]] bool holds(const ObjectDictionary& dictionary) const noexcept {
    return dictionary.get(low) <= dictionary.get(high);
  }
  /// Whether the rule holds with a new value in `slot`.
  [[nodiscard]] bool holds_with(const ObjectDictionary& dictionary, std::uint16_t slot,
                                std::uint64_t raw) const noexcept {
    const T value = static_cast<T>(raw);
    if (slot == low.number) return value <= dictionary.get(high);
    return slot != high.number || dictionary.get(low) <= value;
  }
};
constexpr std::tuple kLogicRules{
    InOrder<std::int32_t>{kValue.position_limit_min, kValue.position_limit_max},
    InOrder<std::int32_t>{kValue.range_min, kValue.range_max},
    InOrder<std::uint32_t>{kValue.velocity_min, kValue.velocity_max},
};

}  // namespace

bool parameters_consistent(const ObjectDictionary& dictionary) noexcept {
  return std::apply([&](const auto&... rule) { return (rule.holds(dictionary) && ...); }, kLogicRules);
}

bool consistent_with(const ObjectDictionary& dictionary, const EntryRow& row, std::uint64_t raw) noexcept {
  return std::apply([&](const auto&... rule) { return (rule.holds_with(dictionary, row.slot, raw) && ...); },
                    kLogicRules);
}

bool possible_value(const EntryRow& row, std::uint64_t raw) noexcept {
  switch (row.slot) {
    case kValue.error_count.number:
      return raw == 0;  // CiA 301 7.5.2.4
    case kValue.input_inversion.number:
      return valid_inversion(raw);
    case kValue.motor_temperature_sensor.number:
      return raw != kUnusedSensor;
    case kValue.motion_profile_type.number:
      return raw == kLinearProfile || raw == kJerkLimitedProfile;
    default:
      break;
  }
  if (kValue.input_functions.contains(row.slot)) return valid_input_function(row.index, raw);
  if (kValue.output_functions.contains(row.slot)) return valid_output_function(row.index, raw);
  return DriveProfile::possible_value(row, raw);
}

}  // namespace driveline::slaves::msd
