#pragma once

#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::ecat_master {

/// Number of the slave's first sync manager with this use; empty when it has none.
[[nodiscard]] std::optional<std::uint8_t> find_sync_manager(const SlaveInfo& slave, esi::SyncManager::Use use);

/// The PDOs that the slave exchanges: the planned PDOs; without a plan the default assignment of its EEPROM, which is
/// not written.
[[nodiscard]] motion::PdoConfiguration exchanged_pdos(const ConfiguredSlave& slave);

/// The process data of `slave`; every PDO is assigned to its sync manager (PdoMapping). Errors: ProcessDataSize when
/// the slave has no sync manager for it.
[[nodiscard]] Result<ProcessDataDemand> make_demand(const ConfiguredSlave& slave);

/// The demands of all slaves, with the number of FMMUs read from each slave. Errors: those of make_demand() and of the
/// bus.
[[nodiscard]] Result<std::vector<ProcessDataDemand>> make_demands(Bus& bus, std::span<const ConfiguredSlave> slaves);

/// Process data sync managers and FMMUs of the slave according to `image`. All FMMUs are written in one datagram, so
/// that the slave contributes to the working counter with all of its process data or not at all. Errors: those of
/// make_demand().
[[nodiscard]] Result<std::vector<RegisterWrite>> process_data_setup(const ConfiguredSlave& slave,
                                                                    const ProcessImage& image);

/// Writes process_data_setup() of all `slaves` in parallel, in PREOP. Errors: also those of the bus.
[[nodiscard]] Result<void> write_process_data_setup(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                    const ProcessImage& image);

/// Sets up a sync manager with `length` bytes; enabled unless that is 0.
[[nodiscard]] RegisterWrite sync_manager_write(SlaveRef slave, std::uint8_t number, const esi::SyncManager& layout,
                                               std::uint16_t length);

}  // namespace driveline::ecat_master
