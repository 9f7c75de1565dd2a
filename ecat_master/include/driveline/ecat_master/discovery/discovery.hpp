#pragma once

#include <optional>
#include <string>
#include <vector>

#include "driveline/ecat_master/bus/bus.hpp"
#include "driveline/ecat_master/error/startup_note.hpp"
#include "driveline/esi/device_description.hpp"

namespace driveline::ecat_master {

/// A slave as found on the line.
struct SlaveInfo {
  SlaveRef ref;                            ///< position on the line and station address
  std::uint16_t alias = 0;                 ///< station alias from the EEPROM
  std::optional<std::uint16_t> device_id;  ///< explicit device identification, if it was requested
  esi::DeviceDescription description;      ///< from its EEPROM
  std::vector<std::byte> sii;              ///< EEPROM content, up to the end of the categories
  /// Error of the EEPROM: SiiBusy, SiiError, SiiContent, SiiChecksum. Only with SiiChecksum the description may be
  /// valid. The other slaves are found nevertheless, and the EEPROM can be repaired.
  std::optional<Error> problem;
  StartupNotes remarks{};  ///< what `description` corrects in the EEPROM
  /// False: the position of the slave is known, its identity is not. A slave with a wrong checksum has not loaded its
  /// EEPROM: its processor has no access and it cannot leave INIT (ETG.1000.4, EEPROM status register, bits 11 and 12).
  [[nodiscard]] bool usable() const noexcept { return !problem; }
};

/// First configured station address; slave n gets this address plus n.
inline constexpr std::uint16_t kFirstStationAddress = 0x1001;
/// Most slaves on a line: addresses stay below the range that other tools use for temporary addresses.
inline constexpr std::uint16_t kMaxSlaves = 4096;

/// Counts the slaves, takes all of them to INIT with their errors acknowledged and their FMMUs and sync managers
/// cleared, assigns station addresses and reads their EEPROMs.
///
/// Errors: NoSlaves, TooManySlaves, those of the bus. An unusable EEPROM is not an error; it is stored in
/// SlaveInfo::problem. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveInfo>> discover(Bus& bus);

/// Reads the EEPROMs of `slaves` without changing their states or settings. One result per slave; an unusable EEPROM is
/// stored in SlaveInfo::problem. Errors: those of the bus. Not real-time safe.
[[nodiscard]] Result<std::vector<SlaveInfo>> inspect(Bus& bus, std::span<const SlaveRef> slaves);

/// The slave as described by its EEPROM `image`, or with the error in SlaveInfo::problem.
[[nodiscard]] SlaveInfo make_slave_info(SlaveRef ref, Result<std::vector<std::byte>> image);

/// Disables all FMMUs and sync managers of all slaves: controllers retain them across a change to INIT, and their
/// settings can only be changed while they are disabled. The slaves should be in INIT. Not real-time safe.
[[nodiscard]] Result<void> clear_channels(Bus& bus);
/// Disables all FMMUs and sync managers of `slaves`. Not real-time safe.
[[nodiscard]] Result<void> clear_channels(Bus& bus, std::span<const SlaveRef> slaves);

}  // namespace driveline::ecat_master
