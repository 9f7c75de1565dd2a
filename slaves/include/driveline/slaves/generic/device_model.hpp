#pragma once

#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>
#include <vector>

#include "driveline/esi/device_description.hpp"
#include "driveline/slaves/device_signals.hpp"
#include "driveline/slaves/od/dictionary_table.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"

namespace driveline::slaves::generic {

/// Adds values that a device needs and its file may omit: sync managers for mailbox and PDOs, their addresses, control
/// bytes and sizes, FMMUs, and the PDI configuration. Existing values are not changed.
[[nodiscard]] esi::DeviceDescription complete_description(esi::DeviceDescription description);

/// The description has more sync managers than a slave controller can have.
struct TooManySyncManagers {
  std::size_t count;  ///< sync managers in the description
  std::size_t most;   ///< maximum of a slave controller
};

/// A sync manager exceeds the memory of a slave controller.
struct SyncManagerBeyondMemory {
  std::size_t number;           ///< from 0
  std::uint16_t start_address;  ///< as in the description
  std::size_t last_address;     ///< last address that it needs
};

/// The device would have more values than a dictionary can hold.
struct TooManyEntries {
  std::size_t count;  ///< objects and entries
  std::size_t most;   ///< maximum of a dictionary
};

/// Why no device can be created from a description.
using DeviceModelError = std::variant<TooManySyncManagers, SyncManagerBeyondMemory, TooManyEntries>;

/// Formats the error as a sentence.
[[nodiscard]] std::string describe(const DeviceModelError& error);

/// Common data of all devices of a type, created from their description: the completed description and the object
/// dictionary. Devices without CoE also have a dictionary of their PDOs, which is not accessible over the bus.
class DeviceModel {
 public:
  /// Creates the model of a device with this description.
  [[nodiscard]] static tl::expected<std::shared_ptr<const DeviceModel>, DeviceModelError> create(
      esi::DeviceDescription description);

  DeviceModel(const DeviceModel&) = delete;  // rows refer to the texts of this object
  DeviceModel& operator=(const DeviceModel&) = delete;
  ~DeviceModel() = default;

  /// Returns the description, completed by complete_description().
  [[nodiscard]] const esi::DeviceDescription& description() const noexcept { return description_; }
  /// Returns the rows of all objects; they live as long as the model.
  [[nodiscard]] const DictionaryTable& table() const noexcept { return *table_; }
  /// Returns the limits of PDO mappings and assignments, see check_pdo_write().
  [[nodiscard]] const PdoLimits& limits() const noexcept { return limits_; }
  /// Returns the maximum number of entries in the process data of a sync manager.
  [[nodiscard]] std::size_t max_fields() const noexcept { return max_fields_; }
  /// Returns the process RAM that holds all sync managers, in KiB.
  [[nodiscard]] std::uint8_t ram_kib() const noexcept { return ram_kib_; }

  /// Returns the input entry (of a TxPDO) with this name: "Value", "Channel 1/Value" with the name of its PDO as
  /// prefix, or its address "6000:01".
  [[nodiscard]] tl::expected<const EntryRow*, SignalNameError> find_input(std::string_view name) const;
  /// Returns the output entry (of an RxPDO) with this name, see find_input().
  [[nodiscard]] tl::expected<const EntryRow*, SignalNameError> find_output(std::string_view name) const;

  /// A PDO entry whose name has the name of its PDO as prefix: "Channel 1/Value".
  struct NamedEntry {
    std::string name;               ///< name that find_input() and find_output() accept
    const EntryRow* row = nullptr;  ///< row in table(); never null
  };
  /// Returns the entries of all TxPDOs; each entry appears once.
  [[nodiscard]] std::vector<NamedEntry> inputs() const;
  /// Returns the entries of all RxPDOs; each entry appears once.
  [[nodiscard]] std::vector<NamedEntry> outputs() const;

 private:
  friend class ModelBuilder;
  DeviceModel() = default;

  esi::DeviceDescription description_;
  std::deque<std::string> texts_;
  std::unique_ptr<const DictionaryTable> table_;
  PdoLimits limits_;
  std::size_t max_fields_ = 0;
  std::uint8_t ram_kib_ = 8;
};

}  // namespace driveline::slaves::generic
