#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "mode_mapping.hpp"

namespace driveline::slaves::msd {
namespace {

using esi::DeviceDescription;

/// Returns the raw little-endian value as hex digits, as in ESI files.
std::string hex(const EntryRow& row, double number) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const auto raw = raw_from_number(row.type, number);
  std::string text;
  for (std::size_t i = 0; i < byte_size(row.type); ++i) {
    const auto byte = static_cast<std::uint8_t>(raw >> (8 * i));
    text += kDigits[byte >> 4];
    text += kDigits[byte & 0xFU];
  }
  return text;
}

esi::ObjectEntry describe(const EntryRow& row) {
  esi::ObjectEntry entry;
  entry.subindex = row.subindex;
  entry.name = entry_name(row);
  entry.type = row.type;
  entry.bit_length = static_cast<std::uint16_t>(8 * byte_size(row));
  entry.readable = (row.access & access::kRead) != 0;
  entry.writable = (row.access & access::kWrite) != 0;
  entry.rx_mappable = (row.access & access::kRxMappable) != 0;
  entry.tx_mappable = (row.access & access::kTxMappable) != 0;
  if (is_string(row.type)) return entry;
  entry.default_hex = hex(row, row.initial);
  if (row.minimum > -1e300) entry.minimum_hex = hex(row, row.minimum);
  if (row.maximum < 1e300) entry.maximum_hex = hex(row, row.maximum);
  return entry;
}

std::vector<esi::Object> describe_objects(const DictionaryTable& table) {
  std::vector<esi::Object> objects;
  for (auto rows = table.next_object(0); !rows.empty(); rows = table.next_object(rows.front().index)) {
    esi::Object object{rows.front().index, std::string(rows.front().name), rows.front().code, {}};
    for (const auto& row : rows) object.entries.push_back(describe(row));
    objects.push_back(std::move(object));
  }
  return objects;
}

std::vector<esi::Pdo> empty_pdos(std::uint16_t first, std::string_view name, std::uint8_t sync_manager) {
  std::vector<esi::Pdo> pdos;
  for (std::uint8_t i = 0; i < kPdoLimits.pdos; ++i) {
    esi::Pdo pdo;
    pdo.index = static_cast<std::uint16_t>(first + i);
    pdo.name = std::string(name) + " " + std::to_string(i + 1);
    pdo.sync_manager = sync_manager;
    pdos.push_back(std::move(pdo));
  }
  return pdos;
}

std::vector<esi::SyncManager> sync_managers() {
  using Use = esi::SyncManager::Use;
  using wire::SyncManagerControl;
  using wire::SyncManagerDirection;
  using wire::SyncManagerMode;
  const SyncManagerControl mailbox_out{SyncManagerMode::kMailbox, SyncManagerDirection::kWrite, false, true, false};
  const SyncManagerControl mailbox_in{SyncManagerMode::kMailbox, SyncManagerDirection::kRead, false, true, false};
  const SyncManagerControl outputs{SyncManagerMode::kThreeBuffer, SyncManagerDirection::kWrite, false, true, true};
  const SyncManagerControl inputs{SyncManagerMode::kThreeBuffer, SyncManagerDirection::kRead, false, true, false};
  return {{Use::kMailboxOut, kMailboxOutStart, kMailboxSize, kMailboxMinSize, kMailboxSize, mailbox_out.raw(), true},
          {Use::kMailboxIn, kMailboxInStart, kMailboxSize, kMailboxMinSize, kMailboxSize, mailbox_in.raw(), true},
          {Use::kOutputs, kOutputsStart, 0, 0, kMaxProcessData, outputs.raw(), true},
          {Use::kInputs, kInputsStart, 0, 0, kMaxProcessData, inputs.raw(), true}};
}

std::vector<esi::DcOpMode> dc_modes() {
  esi::DcOpMode synchronous;
  synchronous.name = "DC-Synchronous";
  synchronous.description = "DC with SYNC0, cycle a multiple of 125 us";
  synchronous.assign_activate = 0x0300;
  synchronous.cycle_time_sync0_factor = 1;
  esi::DcOpMode free_run;
  free_run.name = "Free-Run";
  free_run.description = "Free run, no synchronisation";
  std::vector<esi::DcOpMode> modes = {synchronous, free_run};
  for (auto& mode : mode_op_modes()) modes.push_back(std::move(mode));
  return modes;
}

}  // namespace

DeviceDescription eeprom_description(Variant variant) {
  const VariantFacts& facts = msd::facts(variant);
  DeviceDescription device;
  device.vendor_id = kVendorId;
  device.product_code = facts.product_code;
  device.revision = facts.revision;
  device.vendor_name = "Moog";
  device.group_type = facts.group_type;
  device.group_name = facts.group_name;
  device.type = facts.type;
  device.name = std::string(facts.device_name) + " (simulated)";
  device.device_profile = 402;
  device.mailbox.coe = true;
  device.mailbox.coe_sdo_info = true;
  device.mailbox.coe_pdo_assign = true;
  device.mailbox.coe_pdo_config = true;
  device.mailbox.foe = true;
  device.mailbox.eoe = device.mailbox.eoe_ip = device.mailbox.eoe_mac = true;
  device.bootstrap_rx_offset = kMailboxOutStart;
  device.bootstrap_rx_size = kMailboxSize;
  device.bootstrap_tx_offset = kMailboxInStart;
  device.bootstrap_tx_size = kMailboxSize;
  device.fmmus = {esi::FmmuUse::kOutputs, esi::FmmuUse::kInputs, esi::FmmuUse::kMailboxState};
  device.sync_managers = sync_managers();
  device.rx_pdos = empty_pdos(kPdoLimits.rx_first, "RxPDO", 2);
  device.tx_pdos = empty_pdos(kPdoLimits.tx_first, "TxPDO", 3);
  device.dc_modes = dc_modes();
  // PDI 0x08 (16 bit microcontroller), ESC configuration 0x0E: DC SYNC and latch units on, enhanced link detection.
  device.eeprom_config_data_hex = "080E00CC0A000000000000000000";
  return device;
}

DeviceDescription device_description(Variant variant) {
  auto device = eeprom_description(variant);
  device.objects = describe_objects(dictionary_table(variant));
  return device;
}

}  // namespace driveline::slaves::msd
