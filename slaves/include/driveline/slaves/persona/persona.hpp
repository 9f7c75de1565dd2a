#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace driveline::slaves {

/// Quirks of real devices that a simulated slave can have; each is a row of kPersonas.
enum class PersonaKind : std::uint8_t {
  kSyncTypeReadOnly,
  kSyncTypeUnsupported,
  kSyncTypeByState,
  kSyncCycleReadOnly,
  kSyncCycleLimited,
  kNoSyncObjects,
  kNoInterpolationTime,
  kInterpolationTimeReadOnly,
  kInterpolationTimeLimited,
  kNoOutputAssignment,
  kNoInputAssignment,
  kNoSyncManagerTypes,
  kFixedAssignment,
  kFixedMapping,
  kMappingLimit,
  kAssignmentLimit,
  kOverstatedAssignment,
  kNoCompleteAccess,
  kFourByteAnswers,
  kAnswersWithoutSize,
  kConstantCounter,
  kRequestCounter,
  kJumpingCounter,
  kDeafAfterPreOp,
  kLostRequests,
  kLateAnswers,
  kRequestsToMaster,
  kMessagesToSlave,
  kEmergencies,
  kStaleMessage,
  kSafeOpRefusedOnce,
  kSlowTransitions,
  kNeedsSync0,
  kEepromForApplication,
  kEepromTypesSwapped,
  kEepromTypesZero,
  kEepromDisabled,
  kEepromWithoutPdos,
  kEepromWithoutCategories,
  kEepromWithoutNames,
  kEepromWithoutMailbox,
  kEepromReads4Bytes,
  kSlowEeprom,
  kClock32Bit,
  kNoClock,
  kNoLrw,
  kFewFmmus,
  kWarningBit,
  kFollowBitAlways,
  kLateModeDisplay,
};
/// Number of rows of kPersonas.
inline constexpr std::size_t kPersonaCount = 50;

/// Value of a persona, for users.
struct PersonaValue {
  std::string_view meaning{};  ///< meaning and unit; empty: the persona has no value
  std::uint32_t standard = 0;  ///< value where none is given
  std::uint32_t lowest = 0;    ///< smallest value
  std::uint32_t highest = 0;   ///< largest value
  bool hexadecimal = false;    ///< usually written as 0x...
};

/// A persona for users: the line description, the help and the documentation use this table.
struct PersonaRow {
  PersonaKind kind;         ///< rows are in the order of the enumeration
  std::string_view name;    ///< name in line descriptions; unique
  PersonaValue value;       ///< value behind the name, "deaf-after-preop=300"
  std::string_view text;    ///< what the device does
  std::string_view source;  ///< public report of a device that does it
};

namespace persona_detail {
inline constexpr PersonaValue kNone{};
/// An SDO abort code, `standard` by default.
constexpr PersonaValue abort_code(std::uint32_t standard) noexcept {
  return {"SDO abort code", standard, 1, 0xFFFFFFFF, true};
}
/// A time of 1 ms to 1 min.
constexpr PersonaValue milliseconds(std::uint32_t standard) noexcept {
  return {"ms", standard, 1, 60'000};
}
}  // namespace persona_detail

/// All personas, in the order of the enumeration; see persona_row(). The reports describe the behaviour; docs/
/// real_drives.md links them.
inline constexpr std::array<PersonaRow, kPersonaCount> kPersonas{{
    // Object dictionary
    {PersonaKind::kSyncTypeReadOnly, "sync-type-read-only", persona_detail::kNone,
     "1C32h:01 and 1C33h:01 cannot be written (0x06010002)", "SOEM #609"},
    {PersonaKind::kSyncTypeUnsupported, "sync-type-unsupported", persona_detail::kNone,
     "writing 1C32h:01 and 1C33h:01 is not supported (0x06010000)", "SOEM #899"},
    {PersonaKind::kSyncTypeByState, "sync-type-by-state", persona_detail::kNone,
     "1C32h:01 and 1C33h:01 cannot be written in the present state (0x08000022)", "SOEM #609"},
    {PersonaKind::kSyncCycleReadOnly, "sync-cycle-read-only", persona_detail::kNone,
     "1C32h:02 and 1C33h:02 cannot be written (0x06010002)", "SOEM #364"},
    {PersonaKind::kSyncCycleLimited, "sync-cycle-limited", persona_detail::kNone,
     "1C32h:02 and 1C33h:02 refuse every value as out of range (0x06090030)", "SOEM #364"},
    {PersonaKind::kNoSyncObjects, "no-sync-objects", persona_detail::kNone, "1C32h and 1C33h do not exist (0x06020000)",
     "SOEM #865"},
    {PersonaKind::kNoInterpolationTime, "no-interpolation-time", persona_detail::kNone,
     "60C2h does not exist (0x06020000)", "hal-cia402 #3"},
    {PersonaKind::kInterpolationTimeReadOnly, "interpolation-time-read-only", persona_detail::kNone,
     "60C2h cannot be written (0x06010002)", "hal-cia402 #3"},
    {PersonaKind::kInterpolationTimeLimited, "interpolation-time-limited", persona_detail::kNone,
     "60C2h refuses every value as out of range (0x06090030)", "maxon_epos_ethercat_sdk #3"},
    {PersonaKind::kNoOutputAssignment, "no-output-assignment", persona_detail::abort_code(0x06020000),
     "1C12h cannot be read or written, while 1C13h can", "SOEM #731"},
    {PersonaKind::kNoInputAssignment, "no-input-assignment", persona_detail::abort_code(0x06020000),
     "1C13h cannot be read or written, while 1C12h can", "SOEM #147"},
    {PersonaKind::kNoSyncManagerTypes, "no-sync-manager-types", persona_detail::kNone,
     "1C00h does not exist (0x06020000)", "SOEM #589"},
    {PersonaKind::kFixedAssignment, "fixed-assignment", persona_detail::abort_code(0x06010002),
     "1C12h and 1C13h can be read but not written", "SOEM #311"},
    {PersonaKind::kFixedMapping, "fixed-mapping", persona_detail::abort_code(0x06010002),
     "1600h to 17FFh and 1A00h to 1BFFh can be read but not written", "SOEM #924"},
    {PersonaKind::kMappingLimit,
     "mapping-limit",
     {"entries in a PDO", 8, 1, 255},
     "a PDO takes only this number of entries (0x06040042)",
     "linuxcnc-ethercat #343"},
    {PersonaKind::kAssignmentLimit,
     "assignment-limit",
     {"PDOs", 1, 1, 254},
     "1C12h and 1C13h take only this number of PDOs (0x06040042)",
     "linuxcnc-ethercat #515"},
    {PersonaKind::kOverstatedAssignment,
     "overstated-assignment",
     {"PDOs", 3, 1, 200},
     "1C12h:00 and 1C13h:00 count this number of PDOs more than are assigned",
     "canopen #327"},
    {PersonaKind::kNoCompleteAccess, "no-complete-access", persona_detail::kNone,
     "complete access is refused (0x06010004) although the EEPROM offers it", "SOEM #589"},
    {PersonaKind::kFourByteAnswers, "four-byte-answers", persona_detail::kNone,
     "expedited uploads of shorter objects indicate four bytes", "canopen #395"},
    {PersonaKind::kAnswersWithoutSize, "answers-without-size", persona_detail::kNone,
     "expedited uploads do not indicate their size", "zencan #29"},
    // Mailbox
    {PersonaKind::kConstantCounter,
     "constant-counter",
     {"counter", 1, 0, 7},
     "every mailbox message has the same counter",
     "ethercrab #130"},
    {PersonaKind::kRequestCounter, "request-counter", persona_detail::kNone,
     "mailbox messages repeat the counter of the last request", "SOES #197"},
    {PersonaKind::kJumpingCounter, "jumping-counter", persona_detail::kNone,
     "the counter of mailbox messages does not advance by one", "ethercrab #236"},
    {PersonaKind::kDeafAfterPreOp, "deaf-after-preop", persona_detail::milliseconds(300),
     "requests in the first time after PREOP are taken and never answered", "SOEM #427"},
    {PersonaKind::kLostRequests,
     "lost-requests",
     {"n", 7, 2, 1'000'000},
     "every n-th request is taken and never answered",
     "SOEM #511"},
    {PersonaKind::kLateAnswers, "late-answers", persona_detail::milliseconds(150),
     "mailbox messages leave this time after the last request", "SOEM #220"},
    {PersonaKind::kRequestsToMaster, "requests-to-master", persona_detail::kNone,
     "after each request the device sends an SDO upload of 1000h to the master", "SOEM #970"},
    {PersonaKind::kMessagesToSlave,
     "messages-to-slave",
     {"station address", 0x1002, 1, 0xFFFF, true},
     "after each request the device sends an SDO upload of 1000h to another slave",
     "SOEM #970"},
    {PersonaKind::kEmergencies,
     "emergencies",
     {"messages", 3, 1, 1000},
     "emergencies (3220h) precede the first answers in PREOP",
     "SOEM #781"},
    {PersonaKind::kStaleMessage, "stale-message", persona_detail::kNone,
     "the answer to a request of an earlier master is in the mailbox in PREOP", "SOEM #926"},
    // State machine
    {PersonaKind::kSafeOpRefusedOnce,
     "safeop-refused-once",
     {"AL status code", 0x0052, 1, 0xFFFF, true},
     "the first transition to SAFEOP after power-on fails",
     "SOEM #530"},
    {PersonaKind::kSlowTransitions, "slow-transitions", persona_detail::milliseconds(2500),
     "every change of the AL state takes this time", "SOEM #357"},
    {PersonaKind::kNeedsSync0, "needs-sync0", persona_detail::kNone, "SAFEOP needs SYNC0", "SOEM #890"},
    {PersonaKind::kEepromForApplication, "eeprom-for-application", persona_detail::kNone,
     "the application reads the EEPROM in INIT to PREOP: AL status code 0x0050 unless 0500h gives it access",
     "EtherCAT.NET #55"},
    // EEPROM
    {PersonaKind::kEepromTypesSwapped, "eeprom-types-swapped", persona_detail::kNone,
     "the EEPROM calls the output sync manager an input and the other way round", "SOEM #295"},
    {PersonaKind::kEepromTypesZero, "eeprom-types-zero", persona_detail::kNone,
     "the EEPROM has type 0 for every sync manager", "SOEM #459"},
    {PersonaKind::kEepromDisabled, "eeprom-disabled", persona_detail::kNone,
     "the EEPROM has the process data sync managers disabled", "SOEM #198"},
    {PersonaKind::kEepromWithoutPdos, "eeprom-without-pdos", persona_detail::kNone, "the EEPROM has no PDO categories",
     "SOEM #599"},
    {PersonaKind::kEepromWithoutCategories, "eeprom-without-categories", persona_detail::kNone,
     "the EEPROM ends after its fixed part", "linuxcnc-ethercat #328"},
    {PersonaKind::kEepromWithoutNames, "eeprom-without-names", persona_detail::kNone,
     "PDOs and their entries have no names in the EEPROM", "ethercat-rs #7"},
    {PersonaKind::kEepromWithoutMailbox, "eeprom-without-mailbox", persona_detail::kNone,
     "the fixed part of the EEPROM has no mailbox addresses and sizes", "SOEM #459"},
    {PersonaKind::kEepromReads4Bytes, "eeprom-reads-4-bytes", persona_detail::kNone,
     "an EEPROM read returns 4 bytes, not 8", "SOES #178"},
    {PersonaKind::kSlowEeprom,
     "slow-eeprom",
     {"us", 5000, 1, 1'000'000},
     "every EEPROM command takes this time",
     "SOEM #92"},
    // Slave controller
    {PersonaKind::kClock32Bit, "clock-32-bit", persona_detail::kNone, "the distributed clock has 32 bits", "SOEM #354"},
    {PersonaKind::kNoClock, "no-clock", persona_detail::kNone, "the controller has no distributed clock",
     "ethercrab #373"},
    {PersonaKind::kNoLrw, "no-lrw", persona_detail::kNone,
     "LRW is not executed, and neither registers nor EEPROM say so", "SOEM #224"},
    {PersonaKind::kFewFmmus,
     "few-fmmus",
     {"FMMUs", 3, 2, 8},
     "the controller has only this number of FMMUs",
     "KickCAT #351"},
    // Drive profile
    {PersonaKind::kWarningBit, "warning-bit", persona_detail::kNone,
     "the warning bit of the statusword (bit 7) is always set", "SOEM #517"},
    {PersonaKind::kFollowBitAlways, "follow-bit-always", persona_detail::kNone,
     "bit 12 of the statusword is always set", "ethercat_driver_ros2 #151"},
    {PersonaKind::kLateModeDisplay, "late-mode-display", persona_detail::milliseconds(300),
     "6061h in the process data follows a new mode after this time", "ethercat_driver_ros2 #158"},
}};

/// Returns the row of a kind. Precondition: `kind` is one of the enumeration. \rtsafe
[[nodiscard]] constexpr const PersonaRow& persona_row(PersonaKind kind) noexcept {
  return kPersonas[static_cast<std::size_t>(kind)];
}

/// A quirk of an individual device.
struct Persona {
  PersonaKind kind = PersonaKind::kSyncTypeReadOnly;  ///< which quirk
  std::uint32_t value = 0;                            ///< value of the kind; unused where it has none
};

/// Returns the persona of this kind; null: it is not in the list. \rtsafe
[[nodiscard]] constexpr const Persona* find_persona(std::span<const Persona> personas, PersonaKind kind) noexcept {
  for (const auto& persona : personas) {
    if (persona.kind == kind) return &persona;
  }
  return nullptr;
}
/// Whether the list contains this kind. \rtsafe
[[nodiscard]] constexpr bool has_persona(std::span<const Persona> personas, PersonaKind kind) noexcept {
  return find_persona(personas, kind) != nullptr;
}
/// Returns the value of the persona of this kind; `fallback`: it is not in the list. \rtsafe
[[nodiscard]] constexpr std::uint32_t persona_value(std::span<const Persona> personas, PersonaKind kind,
                                                    std::uint32_t fallback) noexcept {
  const auto* persona = find_persona(personas, kind);
  return persona == nullptr ? fallback : persona->value;
}

}  // namespace driveline::slaves
