#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master {

/// A slave as found on the line.
struct SlaveInfo {
  SlaveRef ref;                            ///< place on the line and station address
  std::uint16_t alias = 0;                 ///< station alias, out of the EEPROM
  std::optional<std::uint16_t> device_id;  ///< explicit device identification, when it has been asked for
  esi::DeviceDescription description;      ///< what its EEPROM says
  std::vector<std::byte> sii;              ///< EEPROM content, up to the end of the categories
  /// What is wrong with the EEPROM: SiiBusy, SiiError, SiiContent, SiiChecksum. There is a description only with
  /// the last one, and then not always. A slave like that does not keep the others from being found, and its EEPROM can
  /// be repaired.
  std::optional<Error> problem;
  /// False: it is known where the slave is, not what. One whose checksum is wrong has not loaded its EEPROM: its own
  /// processor stays cut off and it leaves INIT for nobody (ETG.1000.4, EEPROM status register, bits 11 and 12).
  [[nodiscard]] bool usable() const noexcept { return !problem; }
};

/// First configured station address; slave n gets this plus n.
inline constexpr std::uint16_t kFirstStationAddress = 0x1001;
/// Most slaves of one line: addresses stay below the range that other tools use for temporary ones.
inline constexpr std::uint16_t kMaxSlaves = 4096;

/// Counts the slaves, brings all of them to INIT with their errors acknowledged and their FMMUs and sync managers
/// cleared, gives them station addresses and reads their EEPROMs.
///
/// Errors: NoSlaves, TooManySlaves, those of the bus. Trouble with an EEPROM is a fact about its slave
/// (SlaveInfo::problem), no error. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveInfo>> discover(Bus& bus);

/// What the EEPROMs of `slaves` say, in their order, without changing anything about the slaves. Errors: those of the
/// bus; trouble with an EEPROM is a fact about its slave. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveInfo>> inspect(Bus& bus, std::span<const SlaveRef> slaves);

/// What `image`, the EEPROM of a slave, says about it, or why it says nothing.
[[nodiscard]] SlaveInfo make_slave_info(SlaveRef ref, Result<std::vector<std::byte>> image);

/// Switches off all FMMUs and sync managers of all slaves: controllers keep them across a change to INIT, and their
/// settings can only be changed while they are off. The slaves should be in INIT. Not real-time safe.
[[nodiscard]] Result<void> clear_channels(Bus& bus);
/// The same for some slaves.
[[nodiscard]] Result<void> clear_channels(Bus& bus, std::span<const SlaveRef> slaves);

}  // namespace driveline::ecat_master
