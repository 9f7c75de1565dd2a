#pragma once

#include <cstdint>
#include <string>

namespace driveline::ecat_master {

/// One way in which the settings of a slave disagree: with what was written, with each other, or with its EEPROM.
struct ConfigurationFinding {
  /// Kind of disagreement.
  enum class Kind : std::uint8_t {
    kPdoBytes,      ///< sync manager `number` has `expected` bytes, the PDOs that the slave has assigned `received`
    kPlannedBytes,  ///< the PDOs planned for sync manager `number` have `expected` bytes, those assigned `received`
    kSyncManager,   ///< `field` of sync manager `number` reads as `received` instead of `expected`
    kFmmu,          ///< `field` of FMMU `number` reads as `received` instead of `expected`
    kFmmuBytes,     ///< FMMU `number` maps `received` bytes of sync manager `other`, which has `expected`
    kOverlap,       ///< the memory of sync managers `number` and `other` overlaps
    kEeprom,    ///< `field` of sync manager `number` is `expected` by the description file, `received` by the EEPROM
    kWatchdog,  ///< sync manager `number` triggers a watchdog of `received` us
  };
  /// The setting that reads otherwise, of a sync manager or an FMMU.
  enum class Field : std::uint8_t { kStart, kLength, kControl, kActivation, kLogicalStart, kType };

  Kind kind = Kind::kPdoBytes;   ///< decides how the members below are meant
  Field field = Field::kLength;  ///< kSyncManager, kFmmu and kEeprom
  std::uint8_t number = 0;       ///< of the sync manager or FMMU it is about
  std::uint8_t other = 0;        ///< second sync manager: kFmmuBytes and kOverlap
  std::uint32_t expected = 0;    ///< as planned, or as the other side has it
  std::uint32_t received = 0;    ///< as found; see Kind for both
  bool operator==(const ConfigurationFinding&) const = default;
};

/// The finding as part of a sentence.
[[nodiscard]] std::string describe(const ConfigurationFinding& finding);

}  // namespace driveline::ecat_master
