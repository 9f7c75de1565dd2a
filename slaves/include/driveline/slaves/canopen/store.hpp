#pragma once

#include <span>

#include "driveline/slaves/canopen/application.hpp"
#include "driveline/slaves/canopen/device_options.hpp"

namespace driveline::slaves::cia301 {

/// Adds the node-ID to the COB-IDs at these addresses that have their initial value: they count from it.
void add_node_id(ObjectDictionary& dictionary, std::span<const Address> addresses, std::uint8_t node_id);
/// Gives the COB-IDs at these addresses that count from this node-ID their initial value.
void remove_node_id(ObjectDictionary& dictionary, std::span<const Address> addresses, std::uint8_t node_id);

/// Stored parameters (1010h, 1011h; CiA 301 7.5.2.13, .14): the entries with access::kBackup. A COB-ID that has the
/// value of the node-ID is stored as such, so that another node-ID gives another COB-ID. Allocates only when it is
/// constructed.
class Store {
 public:
  /// Both must outlive this; nothing is stored yet.
  Store(const DictionaryTable& table, const DeviceOptions& options, Application& application);

  /// Handles "save" to 1010h and "load" to 1011h, of which every sub-index from 1 on means all parameters; other rows
  /// are accepted. Errors: kCannotTransferOrStore for a wrong signature, kHardwareError when the application cannot
  /// keep them.
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint32_t raw, const ObjectDictionary& dictionary,
                                       std::uint8_t node_id);
  /// Gives the entries with an index from `first` to `last` their stored values, or the initial ones.
  void restore(ObjectDictionary& dictionary, std::uint16_t first, std::uint16_t last) const;
  /// Replaces the stored values, for instance by those of a file.
  void load(const ObjectDictionary& stored) { stored_.copy_backup_values(stored); }

 private:
  [[nodiscard]] bool save(const ObjectDictionary& dictionary, std::uint8_t node_id);

  const DeviceOptions* options_;
  Application* application_;
  ObjectDictionary stored_;
};

}  // namespace driveline::slaves::cia301
