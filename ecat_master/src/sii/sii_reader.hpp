#pragma once

#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"

namespace driveline::ecat_master {

/// Reads the EEPROM content of all `slaves` in parallel, from word 0 to the end of the categories; each image is as
/// long as the content read. Reads several words per frame where the EEPROM answers immediately, with as many slaves in
/// a frame as fit; contents known by their head (SiiCache) are not read again. First takes the EEPROM interface from
/// the slaves' applications (register 0x0500), and returns it to those that had it.
///
/// Returns an error of the bus, or one result per slave: SiiBusy, SiiError, SiiContent (categories without end). A
/// slave whose EEPROM fails does not delay the others. Not real-time safe.
[[nodiscard]] Result<std::vector<Result<std::vector<std::byte>>>> read_sii(Bus& bus, std::span<const SlaveRef> slaves);

}  // namespace driveline::ecat_master
