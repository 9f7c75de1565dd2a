#pragma once

#include <cstdint>
#include <string>

namespace driveline::ecat_master {

/// A mismatch in the settings of a slave: with the written values, with each other, or with its EEPROM.
struct ConfigurationFinding {
  /// Kind of mismatch.
  enum class Kind : std::uint8_t {
    kPdoBytes,      ///< sync manager `number` has `expected` bytes, the PDOs assigned in the slave `received`
    kPlannedBytes,  ///< the PDOs planned for sync manager `number` have `expected` bytes, those assigned `received`
    kSyncManager,   ///< `field` of sync manager `number` reads as `received` instead of `expected`
    kFmmu,          ///< `field` of FMMU `number` reads as `received` instead of `expected`
    kFmmuBytes,     ///< FMMU `number` maps `received` bytes of sync manager `other`, which has `expected`
    kOverlap,       ///< the memory of sync managers `number` and `other` overlaps
    kEeprom,    ///< `field` of sync manager `number` is `expected` in the description file, `received` in the EEPROM
    kWatchdog,  ///< sync manager `number` triggers a watchdog of `received` us
  };
  /// The setting of a sync manager or FMMU that reads differently.
  enum class Field : std::uint8_t { kStart, kLength, kControl, kActivation, kLogicalStart, kType };

  Kind kind = Kind::kPdoBytes;   ///< determines the meaning of the following members
  Field field = Field::kLength;  ///< used by kSyncManager, kFmmu and kEeprom
  std::uint8_t number = 0;       ///< number of the sync manager or FMMU
  std::uint8_t other = 0;        ///< second sync manager: kFmmuBytes and kOverlap
  std::uint32_t expected = 0;    ///< planned value, or value of the other side
  std::uint32_t received = 0;    ///< value found; see Kind for both
  bool operator==(const ConfigurationFinding&) const = default;
};

/// The finding as part of a sentence.
[[nodiscard]] std::string describe(const ConfigurationFinding& finding);

}  // namespace driveline::ecat_master
