#pragma once

#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::ecat_master {

/// Number of the first sync manager of a slave with this use; nothing when it has none.
[[nodiscard]] std::optional<std::uint8_t> find_sync_manager(const SlaveInfo& slave, esi::SyncManager::Use use);

/// The PDOs the slave exchanges: those that are planned; without any, those that its EEPROM assigns by default, which
/// are not written.
[[nodiscard]] PdoConfiguration exchanged_pdos(const ConfiguredSlave& slave);

/// The process data of `slave`; every PDO goes to its sync manager (PdoMapping). Errors: ProcessDataSize when the slave
/// has no sync manager for them.
[[nodiscard]] Result<ProcessDataDemand> make_demand(const ConfiguredSlave& slave);

/// The demands of all slaves, with the number of FMMUs read from each. Errors: those of make_demand and of the bus.
[[nodiscard]] Result<std::vector<ProcessDataDemand>> make_demands(Bus& bus, std::span<const ConfiguredSlave> slaves);

/// Process data sync managers and FMMUs of the slave as `image` has laid them out. All FMMUs go in one datagram, so
/// that the slave counts for all of its process data at once or not at all. Errors: those of make_demand().
[[nodiscard]] Result<std::vector<RegisterWrite>> process_data_setup(const ConfiguredSlave& slave,
                                                                    const ProcessImage& image);

/// Writes process_data_setup() of all `slaves`, side by side. In PREOP. Errors: also those of the bus.
[[nodiscard]] Result<void> write_process_data_setup(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                    const ProcessImage& image);

/// One sync manager with `length` bytes; enabled when that is more than none.
[[nodiscard]] RegisterWrite sync_manager_write(SlaveRef slave, std::uint8_t number, const esi::SyncManager& layout,
                                               std::uint16_t length);

}  // namespace driveline::ecat_master
