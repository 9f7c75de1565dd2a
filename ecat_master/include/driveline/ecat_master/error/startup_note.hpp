#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "driveline/ecat_master/error/facts.hpp"

namespace driveline::ecat_master {

/// What the start of a slave worked around: one type per kind.
namespace notes {

/// An optional write was refused; the rest of the object was left out.
struct WriteRefused {
  facts::ObjectAddress object{};           ///< entry that was written
  wire::SdoAbort code{};                   ///< reason reported by the slave
  std::optional<std::uint32_t> wanted{};   ///< value that was written; empty: longer than four bytes
  std::optional<std::uint32_t> present{};  ///< value that the slave keeps; empty: not read
  bool operator==(const WriteRefused&) const = default;
};
/// An optional write was accepted, but the entry keeps another value.
struct WriteIgnored {
  facts::ObjectAddress object{};  ///< entry that was written
  std::uint32_t wanted = 0;       ///< value that was written
  std::uint32_t present = 0;      ///< value that was read back
  bool operator==(const WriteIgnored&) const = default;
};
/// The PDOs of a sync manager cannot be read from the slave; those of its description are exchanged.
struct PdosFromDescription {
  facts::ObjectAddress object{};  ///< object that cannot be read
  wire::SdoAbort code{};          ///< reason reported by the slave
  std::uint8_t sync_manager = 0;  ///< number of the sync manager
  std::uint16_t pdos = 0;         ///< number of PDOs that the description assigns to it
  bool operator==(const PdosFromDescription&) const = default;
};
/// The mapping of an assigned PDO cannot be read from the slave; that of its description is used.
struct MappingFromDescription {
  std::uint16_t pdo = 0;  ///< mapping object
  wire::SdoAbort code{};  ///< reason reported by the slave
  bool operator==(const MappingFromDescription&) const = default;
};
/// A list of the slave has fewer readable elements than its sub-index 0 says; those before the gap are used.
struct ListEndsEarly {
  facts::ObjectAddress object{};  ///< first element that cannot be read
  wire::SdoAbort code{};          ///< reason reported by the slave
  std::uint8_t elements = 0;      ///< number of elements by sub-index 0
  bool operator==(const ListEndsEarly&) const = default;
};
/// The slave keeps its own PDOs in a direction; they are exchanged instead of the planned ones.
struct PlannedPdosReplaced {
  bool outputs = false;     ///< outputs; else inputs
  std::uint16_t pdos = 0;   ///< number of PDOs that the slave has assigned
  std::uint16_t bytes = 0;  ///< their length
  bool operator==(const PlannedPdosReplaced&) const = default;
};
/// The slave has PDOs, but none with objects are assigned: it exchanges no process data.
struct NothingAssigned {
  std::uint16_t pdos = 0;  ///< number of PDOs in its description
  bool operator==(const NothingAssigned&) const = default;
};
/// The EEPROM gives a sync manager another use than its control byte; the control byte decides.
struct SyncManagerUse {
  std::uint8_t number = 0;   ///< number of the sync manager
  std::uint8_t type = 0;     ///< type in the EEPROM (ETG.1000.6 Table 23): 0 unused to 4 inputs
  std::uint8_t control = 0;  ///< control byte in the EEPROM
  std::uint8_t taken = 0;    ///< type by the control byte
  bool operator==(const SyncManagerUse&) const = default;
};
/// A refused state was reached when it was requested again.
struct StateReachedLater {
  wire::AlState state = wire::AlState::kNone;              ///< requested state
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< reason of the last refusal
  std::uint8_t refusals = 0;                               ///< number of refusals before
  bool operator==(const StateReachedLater&) const = default;
};
/// A drive lists an operation datum as invalid after it refused a state. Texts are empty where the drive has none.
struct DatumRefusesState {
  facts::InvalidDatum invalid{};  ///< operation datum, and list that has it
  std::string name{};             ///< its name
  std::string value{};            ///< its value as text; conversion factor and decimals are not applied
  std::string minimum{};          ///< its lower limit as text
  std::string maximum{};          ///< its upper limit as text
  std::string unit{};             ///< its unit
  std::uint16_t further = 0;      ///< number of operation data of the list that are not noted
  bool operator==(const DatumRefusesState&) const = default;
};
/// The diagnostic message of a drive, S-0-0095, after the slave refused a state.
struct DriveDiagnosis {
  std::uint8_t drive = 0;  ///< drive of the slave
  std::string text{};      ///< the message
  bool operator==(const DriveDiagnosis&) const = default;
};

}  // namespace notes

/// One of the kinds with its details.
using NoteFacts =
    std::variant<notes::WriteRefused, notes::WriteIgnored, notes::PdosFromDescription, notes::MappingFromDescription,
                 notes::ListEndsEarly, notes::PlannedPdosReplaced, notes::NothingAssigned, notes::SyncManagerUse,
                 notes::StateReachedLater, notes::DatumRefusesState, notes::DriveDiagnosis>;

/// Something unusual about a slave that did not stop the start.
struct StartupNote {
  std::uint16_t slave = 0;  ///< position on the line
  NoteFacts facts;          ///< what happened
  bool operator==(const StartupNote&) const = default;

  /// The details if the note is of the kind, else null.
  template <typename Kind>
  [[nodiscard]] const Kind* as() const noexcept {
    return std::get_if<Kind>(&facts);
  }
};

/// The notes of a start, in the order in which they were made.
using StartupNotes = std::vector<StartupNote>;

/// Adds those of `more` that are not in `notes` yet: a slave that starts again and again has its notes once.
void add_new(StartupNotes& notes, const StartupNotes& more);

/// The note as one sentence with all its details.
[[nodiscard]] std::string describe(const StartupNote& note);

}  // namespace driveline::ecat_master
