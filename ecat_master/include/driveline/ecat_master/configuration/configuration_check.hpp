#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/configuration/configurator.hpp"

namespace driveline::ecat_master {

/// One way in which the settings of a slave disagree: with what was written, with each other, or with its EEPROM.
struct ConfigurationFinding {
  /// What disagrees with what.
  enum class Kind : std::uint8_t {
    kPdoBytes,      ///< sync manager `number` has `expected` bytes, the PDOs that the slave has assigned `received`
    kPlannedBytes,  ///< the PDOs planned for sync manager `number` have `expected` bytes, those assigned `received`
    kSyncManager,   ///< `field` of sync manager `number` reads as `received`, `expected` was to be there
    kFmmu,          ///< `field` of FMMU `number` likewise
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

/// Reads sync managers, FMMUs, watchdogs and assigned PDOs of a slave back and compares them with what was planned,
/// with each other, and with the EEPROM where a description file went before it. What `code` is about comes first; for
/// refused mailboxes (0x0016) nothing but these is looked at. `image` as it was laid out; empty before. Registers that
/// cannot be read and objects that the slave does not tell are left out. Not real-time safe.
[[nodiscard]] std::vector<ConfigurationFinding> check_configuration(Bus& bus, const ConfiguredSlave& slave,
                                                                    const ProcessImage& image, wire::AlStatusCode code);

/// A refused transition with the first finding about its slave in it; describe() tells it. Other errors as they are.
[[nodiscard]] Error explain_state_error(Bus& bus, std::span<const ConfiguredSlave> slaves, const ProcessImage& image,
                                        const Error& error);

/// describe(error), for a refused transition with all findings about its slave.
[[nodiscard]] std::string describe_with_findings(Bus& bus, std::span<const ConfiguredSlave> slaves,
                                                 const ProcessImage& image, const Error& error);

/// The finding that explain_state_error() has put into an error; nothing when there is none.
[[nodiscard]] std::optional<ConfigurationFinding> finding_of(const Error& error) noexcept;

}  // namespace driveline::ecat_master
