#pragma once

#include "driveline/ecat_master/error/startup_note.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master {

/// Corrects the uses of sync managers in the description of an EEPROM whose types are missing (0) or contradict the
/// control bytes: the controller works by the control byte, whatever the type says. Returns a note per correction.
[[nodiscard]] StartupNotes correct_sync_manager_uses(std::uint16_t slave, esi::DeviceDescription& device);

}  // namespace driveline::ecat_master
