#pragma once

#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Reads the EEPROM content of all `slaves` side by side, from word 0 to the end of the categories; each image is as
/// long as what was read. Several words per frame where the EEPROM answers at once, as many slaves in a frame as fit;
/// contents that the bus knows by their head (SiiCache) are not read again. Takes the EEPROM interface from the slaves'
/// applications first (register 0x0500).
///
/// Result: those of the bus, or one result per slave: SiiBusy, SiiError, SiiContent (categories without end).
/// A slave whose EEPROM fails does not hold up the others. Not real-time safe.
[[nodiscard]] Result<std::vector<Result<std::vector<std::byte>>>> read_sii(Bus& bus, std::span<const SlaveRef> slaves);

}  // namespace driveline::ecat_master
