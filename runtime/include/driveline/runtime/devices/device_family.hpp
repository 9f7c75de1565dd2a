#pragma once

#include <cstdint>
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

/// Input from which a family reads its device.
struct DeviceTable {
  TomlReader& keys;                 ///< the [[slave]] table
  std::filesystem::path directory;  ///< folder of the line description; paths are relative to it
  /// Device of the ESI file that the table names; null: it names none.
  std::shared_ptr<const esi::DeviceDescription> esi;
  /// Devices of the preceding tables, so that data can be shared.
  std::span<const std::shared_ptr<const SlaveDevice>> before;
};

/// A kind of device, named by `model` in a line description, with the rules of its drives. Registered in a
/// DeviceRegistry.
///
/// `model` and identity serve different purposes: `model` determines the simulated device, read(); the expected
/// identity determines how the master treats a drive, rules_for(), including a real one on a network interface.
///
/// Immutable; any thread.
class DeviceFamily {
 public:
  DeviceFamily() = default;
  DeviceFamily(const DeviceFamily&) = delete;
  DeviceFamily& operator=(const DeviceFamily&) = delete;
  virtual ~DeviceFamily() = default;

  /// Returns the value of `model` in a [[slave]].
  [[nodiscard]] virtual std::string_view key() const noexcept = 0;

  /// Returns the keys of a [[slave]] that read() reads.
  [[nodiscard]] virtual std::vector<std::string_view> own_keys() const = 0;

  /// Reads the own keys of the family. Never null.
  ///
  /// Errors in the keys are exceptions, thrown by the functions of the reader and by TomlReader::fail() for checks of
  /// the family. They are not values, unlike elsewhere, because a dozen keys are read in a row, each call can fail, and
  /// a failure can only be passed on with its file and line. load_line_config() catches what the reader throws and
  /// returns it as its error; no exception leaves the library.
  [[nodiscard]] virtual std::shared_ptr<const SlaveDevice> read(const DeviceTable& table) const = 0;

  /// Whether a [[slave]] with none of own_keys() is simulated as a device of this identity and revision, so that such a
  /// device found on a line can be described by key().
  [[nodiscard]] virtual bool simulates(const DeviceIdentity& /*identity*/, std::uint32_t /*revision*/) const noexcept {
    return false;
  }

  /// Returns the rules of a drive with this identity; null: it is not of this family. Valid as long as the family.
  [[nodiscard]] virtual const DriveRules* rules_for(const DeviceIdentity& /*identity*/) const noexcept {
    return nullptr;
  }
};

}  // namespace driveline::runtime
