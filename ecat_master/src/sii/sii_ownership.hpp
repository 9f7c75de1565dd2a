#pragma once

#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Takes the EEPROM interface of `slaves` for the master: forced take-over, then hand-over to EtherCAT (ETG.1000.4
/// 6.4.3), because the application may hold it. Returns the slaves whose application had it (register 0x0500, bit 0).
/// Errors: those of the bus; slaves that do not answer are left out. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveRef>> take_from_applications(Bus& bus, std::span<const SlaveRef> slaves);

/// Gives the EEPROM interface of `slaves` to their applications. Errors: those of the bus, WorkingCounter. Not
/// real-time safe.
[[nodiscard]] Result<void> give_to_applications(Bus& bus, std::span<const SlaveRef> slaves);

}  // namespace driveline::ecat_master
