#include "driveline/slaves/canopen/store.hpp"

namespace driveline::slaves::cia301 {
namespace {

constexpr std::uint32_t kSave = 0x65766173;  ///< "save"
constexpr std::uint32_t kLoad = 0x64616F6C;  ///< "load"

}  // namespace

Store::Store(const DictionaryTable& table, const DeviceOptions& options, Application& application)
    : options_(&options), application_(&application), stored_(table) {}

SdoResult<void> Store::accept(const EntryRow& row, std::uint32_t raw, const ObjectDictionary& dictionary) {
  const bool save_object = row.index == 0x1010 && row.subindex != 0;
  const bool load_object = row.index == 0x1011 && row.subindex != 0;
  if (!save_object && !load_object) return {};
  if (raw != (save_object ? kSave : kLoad)) return tl::unexpected(sdo::SdoAbort::kCannotTransferOrStore);
  bool kept = false;
  if (save_object) {
    kept = save(dictionary);
  } else {
    stored_.reset();  // acts after the next reset (CiA 301 7.5.2.14)
    kept = application_->keep(stored_);
  }
  if (!kept) return tl::unexpected(sdo::SdoAbort::kHardwareError);
  return {};
}

bool Store::save(const ObjectDictionary& dictionary) {
  stored_.copy_backup_values(dictionary);
  for (const Address& address : options_->node_relative) {
    const EntryRow* row = dictionary.table().find(address.index, address.subindex);
    if (row == nullptr || row->slot == slot::kConstant) continue;
    if (stored_.raw(*row) == initial_raw(*row) + node_id_) stored_.set_raw(row->slot, initial_raw(*row));
  }
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

void Store::add_node_id(ObjectDictionary& dictionary, std::uint8_t node_id) {
  node_id_ = node_id;
  for (const Address& address : options_->node_relative) {
    const EntryRow* row = dictionary.table().find(address.index, address.subindex);
    if (row == nullptr || row->slot == slot::kConstant) continue;
    if (dictionary.raw(*row) == initial_raw(*row)) dictionary.set_raw(row->slot, initial_raw(*row) + node_id);
  }
}

}  // namespace driveline::slaves::cia301
