#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/devices/device_family.hpp"
#include "driveline/runtime/error.hpp"

namespace driveline::runtime {

/// Family of the devices that are simulated from an ESI file or an EEPROM image.
inline constexpr std::string_view kDeviceOfFile = "generic";

/// Families that a line description can name: those of the library, and those added by its user.
///
///   runtime::DeviceRegistry devices;
///   if (auto added = devices.add(std::make_shared<AcmeFamily>()); !added) return fail(describe(added.error()));
///   auto line = runtime::Line::from_file("cell.toml", {.devices = devices});
///
/// Copyable value: copies share the families, which never change.
class DeviceRegistry {
 public:
  /// Contains `msd`, `servoone`, `servoone_junior`, `generic` and `eds`.
  DeviceRegistry();

  /// Adds a family. Error: null, an empty key, or a key that exists already (kCall); the registry is unchanged.
  [[nodiscard]] Result<void> add(std::shared_ptr<const DeviceFamily> family);

  /// Returns the families in the order in which they were added; the first one is used for a [[slave]] without `model`.
  [[nodiscard]] std::span<const std::shared_ptr<const DeviceFamily>> families() const noexcept { return families_; }
  /// Returns the family with this key; null: there is none.
  [[nodiscard]] const DeviceFamily* find(std::string_view key) const noexcept;
  /// Returns the first family that simulates such a device without further keys; null: there is none.
  [[nodiscard]] const DeviceFamily* find_simulated(const DeviceIdentity& identity,
                                                   std::uint32_t revision) const noexcept;
  /// Returns all keys, for messages: "a", "b".
  [[nodiscard]] std::string known_keys() const;

  /// Returns the rules of a drive with this identity: those of the family that knows it, the one added last first; the
  /// rules of CiA 402 if no family knows it. Valid as long as the families.
  [[nodiscard]] const DriveRules& rules_for(const DeviceIdentity& identity) const noexcept;
  /// Whether a family has rules for a drive with this identity.
  [[nodiscard]] bool has_rules_for(const DeviceIdentity& identity) const noexcept {
    return own_rules(identity) != nullptr;
  }

 private:
  [[nodiscard]] const DriveRules* own_rules(const DeviceIdentity& identity) const noexcept;

  std::vector<std::shared_ptr<const DeviceFamily>> families_;
};

}  // namespace driveline::runtime
