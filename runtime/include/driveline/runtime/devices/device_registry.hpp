#pragma once

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

/// The families that a line file can name: those that come with the library, and those that its user adds.
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

  /// One more. Error: none is given, or its key is empty or there already (kCall); the registry is as it was.
  [[nodiscard]] Result<void> add(std::shared_ptr<const DeviceFamily> family);

  /// In the order in which they were added; the first is that of a [[slave]] which does not say.
  [[nodiscard]] std::span<const std::shared_ptr<const DeviceFamily>> families() const noexcept { return families_; }
  /// The family with this key; null: there is none.
  [[nodiscard]] const DeviceFamily* find(std::string_view key) const noexcept;
  /// All keys, for a sentence: "a", "b".
  [[nodiscard]] std::string known_keys() const;

  /// How the master treats a drive with this identity: as the family says that knows it, the one that was added last
  /// first; a drive that none knows as CiA 402 has it. As long-lived as the families.
  [[nodiscard]] const DriveRules& rules_for(const DeviceIdentity& identity) const noexcept;

 private:
  std::vector<std::shared_ptr<const DeviceFamily>> families_;
};

}  // namespace driveline::runtime
