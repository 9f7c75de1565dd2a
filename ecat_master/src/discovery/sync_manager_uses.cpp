#include "discovery/sync_manager_uses.hpp"

#include <algorithm>
#include <optional>

#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;
using wire::SyncManagerDirection;
using wire::SyncManagerMode;

/// The use by the control byte; empty: a reserved mode or direction.
std::optional<Use> use_by_control(std::uint8_t control) {
  const auto byte = wire::SyncManagerControl::from_raw(control);
  const bool writes = byte.direction == SyncManagerDirection::kWrite;
  if (!writes && byte.direction != SyncManagerDirection::kRead) return std::nullopt;
  if (byte.mode == SyncManagerMode::kMailbox) return writes ? Use::kMailboxOut : Use::kMailboxIn;
  if (byte.mode == SyncManagerMode::kThreeBuffer) return writes ? Use::kOutputs : Use::kInputs;
  return std::nullopt;
}

bool has_pdo_on(const esi::DeviceDescription& device, std::size_t number) {
  const auto on_it = [number](const esi::Pdo& pdo) { return pdo.sync_manager == number; };
  return std::any_of(device.rx_pdos.begin(), device.rx_pdos.end(), on_it) ||
         std::any_of(device.tx_pdos.begin(), device.tx_pdos.end(), on_it);
}

/// Whether the control byte of the sync manager says more than its type. A control byte of 0, which is that of inputs,
/// may have been left out, so alone it does not contradict a type.
bool decides(const esi::DeviceDescription& device, std::size_t number, bool swapped) {
  const auto& manager = device.sync_managers[number];
  if (manager.use == Use::kUnused) return manager.start_address != 0 && (manager.enable || has_pdo_on(device, number));
  return manager.control != 0 || swapped;
}

}  // namespace

StartupNotes correct_sync_manager_uses(std::uint16_t slave, esi::DeviceDescription& device) {
  const auto& managers = device.sync_managers;
  const bool swapped = std::any_of(managers.begin(), managers.end(), [](const esi::SyncManager& manager) {
    return manager.use == Use::kInputs && use_by_control(manager.control) == Use::kOutputs;
  });
  StartupNotes corrections;
  for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
    auto& manager = device.sync_managers[n];
    const auto taken = use_by_control(manager.control);
    if (!taken || *taken == manager.use || !decides(device, n, swapped)) continue;
    corrections.push_back(
        {slave, notes::SyncManagerUse{static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(manager.use),
                                      manager.control, static_cast<std::uint8_t>(*taken)}});
    manager.use = *taken;
  }
  return corrections;
}

}  // namespace driveline::ecat_master
