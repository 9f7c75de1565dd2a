#include <algorithm>
#include <array>

#include "driveline/slaves/generic/device_model.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::slaves::generic {
namespace {

using esi::DeviceDescription;
using esi::FmmuUse;
using esi::SyncManager;
using Use = SyncManager::Use;

/// Large enough for every service, and the size that small controllers have.
constexpr std::uint16_t kMailboxSize = 128;

bool has_use(const DeviceDescription& device, Use use) {
  return std::any_of(device.sync_managers.begin(), device.sync_managers.end(),
                     [use](const SyncManager& manager) { return manager.use == use; });
}

void add_sync_manager(DeviceDescription& device, Use use) {
  SyncManager manager;
  manager.use = use;
  manager.enable = true;
  device.sync_managers.push_back(manager);
}

/// Adds sync managers in the order of ETG.1000.6: mailbox out and in, outputs, inputs.
void add_sync_managers(DeviceDescription& device) {
  if (device.mailbox.any() && !has_use(device, Use::kMailboxOut) && device.sync_managers.empty()) {
    add_sync_manager(device, Use::kMailboxOut);
    add_sync_manager(device, Use::kMailboxIn);
  }
  if (!device.rx_pdos.empty() && !has_use(device, Use::kOutputs)) add_sync_manager(device, Use::kOutputs);
  if (!device.tx_pdos.empty() && !has_use(device, Use::kInputs)) add_sync_manager(device, Use::kInputs);
}

std::uint8_t usual_control(Use use) {
  using wire::SyncManagerControl;
  using wire::SyncManagerDirection;
  using wire::SyncManagerMode;
  const bool mailbox = use == Use::kMailboxOut || use == Use::kMailboxIn;
  const bool write = use == Use::kMailboxOut || use == Use::kOutputs;
  SyncManagerControl control;
  control.mode = mailbox ? SyncManagerMode::kMailbox : SyncManagerMode::kThreeBuffer;
  control.direction = write ? SyncManagerDirection::kWrite : SyncManagerDirection::kRead;
  control.interrupt_pdi = true;
  control.watchdog_trigger = use == Use::kOutputs;
  return control.raw();
}

std::size_t pdo_bits(const std::vector<esi::Pdo>& pdos, bool assigned, std::uint8_t number) {
  std::size_t bits = 0;
  for (const auto& pdo : pdos) {
    if (assigned && pdo.sync_manager != number) continue;
    for (const auto& entry : pdo.entries) bits += entry.bit_length;
  }
  return bits;
}

/// Returns the bytes in RAM that a sync manager may need: all PDOs of its direction could be assigned to it.
std::size_t area(const DeviceDescription& device, const SyncManager& manager) {
  switch (manager.use) {
    case Use::kMailboxOut:
    case Use::kMailboxIn:
      return std::max(manager.default_size, manager.max_size);
    case Use::kOutputs:
    case Use::kInputs: {
      const auto& pdos = manager.use == Use::kOutputs ? device.rx_pdos : device.tx_pdos;
      return 3 * std::max<std::size_t>((pdo_bits(pdos, false, 0) + 7) / 8, manager.default_size);
    }
    case Use::kUnused:
      break;
  }
  return 0;
}

/// Places the sync managers without an address after those with one, at even addresses.
void place_sync_managers(DeviceDescription& device) {
  std::size_t next = wire::kProcessRamStart;
  for (const auto& manager : device.sync_managers) {
    if (manager.start_address >= wire::kProcessRamStart) {
      next = std::max(next, manager.start_address + area(device, manager));
    }
  }
  for (auto& manager : device.sync_managers) {
    if (manager.use == Use::kUnused) continue;
    if (manager.control == 0 && manager.use != Use::kInputs) manager.control = usual_control(manager.use);  // 0: read
    const bool mailbox = manager.use == Use::kMailboxOut || manager.use == Use::kMailboxIn;
    if (mailbox && manager.default_size == 0) manager.default_size = kMailboxSize;
    if (manager.start_address != 0) continue;
    next = (next + 1) / 2 * 2;
    manager.start_address = static_cast<std::uint16_t>(std::min<std::size_t>(next, 0xFFFF));
    next += area(device, manager);
  }
}

/// Sets the length in the SII to that of the PDOs assigned by default, unless the file specifies a length.
void size_sync_managers(DeviceDescription& device) {
  for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
    auto& manager = device.sync_managers[n];
    if ((manager.use != Use::kOutputs && manager.use != Use::kInputs) || manager.default_size != 0) continue;
    const auto& pdos = manager.use == Use::kOutputs ? device.rx_pdos : device.tx_pdos;
    const auto bytes = (pdo_bits(pdos, true, static_cast<std::uint8_t>(n)) + 7) / 8;
    manager.default_size = static_cast<std::uint16_t>(std::min<std::size_t>(bytes, 0xFFFF));
  }
}

/// Assigns the PDOs of a direction to its sync manager if it is the only one and the assignment is neither writable nor
/// specified.
void assign_pdos(std::vector<esi::Pdo>& pdos, Use use, const DeviceDescription& device) {
  const auto& managers = device.sync_managers;
  const auto is_use = [use](const SyncManager& manager) { return manager.use == use; };
  if (device.mailbox.coe_pdo_assign || std::count_if(managers.begin(), managers.end(), is_use) != 1) return;
  if (std::any_of(pdos.begin(), pdos.end(), [](const esi::Pdo& pdo) { return pdo.sync_manager.has_value(); })) return;
  const auto number = std::find_if(managers.begin(), managers.end(), is_use) - managers.begin();
  for (auto& pdo : pdos) pdo.sync_manager = static_cast<std::uint8_t>(number);
}

void add_fmmus(DeviceDescription& device) {
  if (!device.fmmus.empty()) return;
  for (const auto& manager : device.sync_managers) {
    if (manager.use == Use::kOutputs) device.fmmus.push_back(FmmuUse::kOutputs);
    if (manager.use == Use::kInputs) device.fmmus.push_back(FmmuUse::kInputs);
  }
  if (device.mailbox.any()) device.fmmus.push_back(FmmuUse::kMailboxState);
}

}  // namespace

DeviceDescription complete_description(DeviceDescription description) {
  add_sync_managers(description);
  place_sync_managers(description);
  assign_pdos(description.rx_pdos, Use::kOutputs, description);
  assign_pdos(description.tx_pdos, Use::kInputs, description);
  size_sync_managers(description);
  add_fmmus(description);
  if (description.eeprom_config_data_hex.empty()) {
    // PDI control: SPI slave for a device with an application, else digital I/O, where the controller follows AL
    // control on its own (register 0x0140, device emulation).
    description.eeprom_config_data_hex =
        description.mailbox.any() ? "050C000000000000000000000000" : "0401000000000000000000000000";
  }
  return description;
}

}  // namespace driveline::slaves::generic
