#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/msd_table.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "mode_mapping.hpp"
#include "object_description.hpp"

namespace driveline::slaves::msd {
namespace {

using esi::DeviceDescription;

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
