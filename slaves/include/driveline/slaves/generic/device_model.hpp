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

/// Completes a description with values that a device needs and its file may leave out: sync managers for its mailbox
/// and its PDOs, their addresses, control bytes and sizes, FMMUs, the PDI configuration. Existing values are kept.
[[nodiscard]] esi::DeviceDescription complete_description(esi::DeviceDescription description);

/// The description has more sync managers than a slave controller.
struct TooManySyncManagers {
  std::size_t count;  ///< in the description
  std::size_t most;   ///< of a slave controller
};

/// A sync manager ends beyond the memory of a slave controller.
struct SyncManagerBeyondMemory {
  std::size_t number;           ///< from 0
  std::uint16_t start_address;  ///< as in the description
  std::size_t last_address;     ///< that it needs
};

/// The device would have more values than a dictionary holds.
struct TooManyEntries {
  std::size_t count;  ///< objects and entries
  std::size_t most;   ///< of a dictionary
};

/// Why a description cannot be a device.
using DeviceModelError = std::variant<TooManySyncManagers, SyncManagerBeyondMemory, TooManyEntries>;

/// The error as a sentence.
[[nodiscard]] std::string describe(const DeviceModelError& error);

/// Everything that devices of one type have in common, made from their description: the completed description and the
/// object dictionary. Devices without CoE have a dictionary of their PDOs as well, which cannot be read over the bus.
class DeviceModel {
 public:
  /// The model of a device with this description.
  [[nodiscard]] static tl::expected<std::shared_ptr<const DeviceModel>, DeviceModelError> create(
      esi::DeviceDescription description);

  DeviceModel(const DeviceModel&) = delete;  // rows refer to the texts in here
  DeviceModel& operator=(const DeviceModel&) = delete;
  ~DeviceModel() = default;

  /// As completed by complete_description().
  [[nodiscard]] const esi::DeviceDescription& description() const noexcept { return description_; }
  /// Rows of all objects; as long-lived as the model.
  [[nodiscard]] const DictionaryTable& table() const noexcept { return *table_; }
  /// Limits for writing PDO mappings and assignments, see check_pdo_write().
  [[nodiscard]] const PdoLimits& limits() const noexcept { return limits_; }
  /// Most entries the process data of a sync manager can have.
  [[nodiscard]] std::size_t max_fields() const noexcept { return max_fields_; }
  /// Process RAM that holds all sync managers, in KiB.
  [[nodiscard]] std::uint8_t ram_kib() const noexcept { return ram_kib_; }

  /// The input entry (of a TxPDO) with this name: "Value", "Channel 1/Value" with the name of its PDO in front, or its
  /// address "6000:01".
  [[nodiscard]] tl::expected<const EntryRow*, SignalNameError> find_input(std::string_view name) const;
  /// The same for output entries (of RxPDOs).
  [[nodiscard]] tl::expected<const EntryRow*, SignalNameError> find_output(std::string_view name) const;

  /// An entry that PDOs can hold, with the name of its PDO in front: "Channel 1/Value".
  struct NamedEntry {
    std::string name;               ///< as find_input() and find_output() take it
    const EntryRow* row = nullptr;  ///< never null; in table()
  };
  /// All of them, each once: inputs are the entries of TxPDOs, outputs those of RxPDOs.
  [[nodiscard]] std::vector<NamedEntry> inputs() const;
  /// See inputs().
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
