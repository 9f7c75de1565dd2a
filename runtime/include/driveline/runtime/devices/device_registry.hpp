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

/// The family of devices that are simulated from an ESI file or an EEPROM image.
inline constexpr std::string_view kDeviceOfFile = "generic";

/// The families that a line description can name: those of the library, and those added by its user.
///
///   runtime::DeviceRegistry devices;
///   if (auto added = devices.add(std::make_shared<AcmeFamily>()); !added) return fail(describe(added.error()));
///   auto line = runtime::Line::from_file("cell.toml", {.devices = devices});
///
/// A value: copies share the families, which never change.
class DeviceRegistry {
 public:
  /// With `msd`, `servoone`, `servoone_junior` and `generic`.
  DeviceRegistry();

  /// Adds a family. Error: null, an empty key, or a key that exists already (kCall); the registry is unchanged.
  [[nodiscard]] Result<void> add(std::shared_ptr<const DeviceFamily> family);

  /// In the order in which they were added; the first is that of a [[slave]] without `model`.
  [[nodiscard]] std::span<const std::shared_ptr<const DeviceFamily>> families() const noexcept { return families_; }
  /// The family with this key; null: there is none.
  [[nodiscard]] const DeviceFamily* find(std::string_view key) const noexcept;
  /// The first family that simulates such a device without further keys; null: there is none.
  [[nodiscard]] const DeviceFamily* find_simulated(const DeviceIdentity& identity,
                                                   std::uint32_t revision) const noexcept;
  /// All keys, for messages: "a", "b".
  [[nodiscard]] std::string known_keys() const;

  /// Rules of a drive with this identity: those of the family that knows it, families added later first; CiA 402 alone
  /// when none does. Valid as long as the families.
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
