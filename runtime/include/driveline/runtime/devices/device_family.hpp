#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "driveline/esi/device_description.hpp"
#include "driveline/runtime/devices/drive_rules.hpp"
#include "driveline/runtime/devices/slave_device.hpp"
#include "driveline/runtime/toml/toml_reader.hpp"

namespace driveline::runtime {

/// What a family reads its device from.
struct DeviceTable {
  TomlReader& keys;                 ///< the [[slave]] table
  std::filesystem::path directory;  ///< of the line file; paths in it are relative to that
  /// The device of the ESI file that the table names; null: it names none.
  std::shared_ptr<const esi::DeviceDescription> esi;
  /// Those of the tables above, for what they can share.
  std::span<const std::shared_ptr<const SlaveDevice>> before;
};

/// A kind of device that a line file can name by `model`, and what is known of its drives. Registered in a
/// DeviceRegistry.
///
/// Two questions are kept apart. What is simulated is decided by `model`: read(). How the master treats a drive is
/// decided by who the line file expects there: rules_for(), also for a real drive on a network interface.
///
/// Immutable; any thread.
class DeviceFamily {
 public:
  DeviceFamily() = default;
  DeviceFamily(const DeviceFamily&) = delete;
  DeviceFamily& operator=(const DeviceFamily&) = delete;
  virtual ~DeviceFamily() = default;

  /// The value of `model` in a [[slave]].
  [[nodiscard]] virtual std::string_view key() const noexcept = 0;

  /// The keys of a [[slave]] that read() asks for.
  [[nodiscard]] virtual std::vector<std::string_view> own_keys() const = 0;

  /// Reads those keys. Never null. What is wrong with them is thrown by the reader, TomlReader::fail() included.
  [[nodiscard]] virtual std::shared_ptr<const SlaveDevice> read(const DeviceTable& table) const = 0;

  /// How the master treats a drive with this identity; null: it is none of this family. As long-lived as the family.
  [[nodiscard]] virtual const DriveRules* rules_for(const DeviceIdentity& /*identity*/) const noexcept {
    return nullptr;
  }
};

}  // namespace driveline::runtime
