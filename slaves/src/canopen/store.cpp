#include "driveline/slaves/canopen/store.hpp"

namespace driveline::slaves::cia301 {
namespace {

constexpr std::uint32_t kSave = 0x65766173;  ///< "save"
constexpr std::uint32_t kLoad = 0x64616F6C;  ///< "load"

/// Calls `change` with each of these rows, its value, and the initial one.
template <typename Change>
void for_each_value(ObjectDictionary& dictionary, std::span<const Address> addresses, const Change& change) {
  for (const Address& address : addresses) {
    const EntryRow* row = dictionary.table().find(address.index, address.subindex);
    if (row != nullptr && row->slot != slot::kConstant) change(*row, dictionary.raw(*row), initial_raw(*row));
  }
}

}  // namespace

void add_node_id(ObjectDictionary& dictionary, std::span<const Address> addresses, std::uint8_t node_id) {
  for_each_value(dictionary, addresses, [&](const EntryRow& row, std::uint64_t value, std::uint64_t initial) {
    if (value == initial) dictionary.set_raw(row.slot, initial + node_id);
  });
}

void remove_node_id(ObjectDictionary& dictionary, std::span<const Address> addresses, std::uint8_t node_id) {
  for_each_value(dictionary, addresses, [&](const EntryRow& row, std::uint64_t value, std::uint64_t initial) {
    if (value == initial + node_id) dictionary.set_raw(row.slot, initial);
  });
}

Store::Store(const DictionaryTable& table, const DeviceOptions& options, Application& application)
    : options_(&options), application_(&application), stored_(table) {}

SdoResult<void> Store::accept(const EntryRow& row, std::uint32_t raw, const ObjectDictionary& dictionary,
                              std::uint8_t node_id) {
  const bool save_object = row.index == 0x1010 && row.subindex != 0;
  const bool load_object = row.index == 0x1011 && row.subindex != 0;
  if (!save_object && !load_object) return {};
  if (raw != (save_object ? kSave : kLoad)) return tl::unexpected(sdo::SdoAbort::kCannotTransferOrStore);
  bool kept = false;
  if (save_object) {
    kept = save(dictionary, node_id);
  } else {
    stored_.reset();  // acts after the next reset (CiA 301 7.5.2.14)
    kept = application_->keep(stored_);
  }
  if (!kept) return tl::unexpected(sdo::SdoAbort::kHardwareError);
  return {};
}

bool Store::save(const ObjectDictionary& dictionary, std::uint8_t node_id) {
  stored_.copy_backup_values(dictionary);
  remove_node_id(stored_, options_->node_relative, node_id);
  return application_->keep(stored_);
}

void Store::restore(ObjectDictionary& dictionary, std::uint16_t first, std::uint16_t last) const {
  for (const EntryRow& row : dictionary.table().rows()) {
    if (row.index < first || row.index > last || row.slot == slot::kConstant) continue;
    const bool stored = (row.access & access::kBackup) != 0;
    if (is_string(row.type)) {
      dictionary.text(row.slot).assign(stored ? std::string_view(stored_.text(row.slot)) : row.text);
    } else {
      dictionary.set_raw(row.slot, stored ? stored_.raw(row.slot) : initial_raw(row));
    }
  }
}

}  // namespace driveline::slaves::cia301
