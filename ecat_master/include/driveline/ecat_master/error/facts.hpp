#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "driveline/ecat_master/error/configuration_finding.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"
#include "driveline/wire/eoe.hpp"
#include "driveline/wire/foe.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/sdo_abort.hpp"
#include "driveline/wire/soe.hpp"

namespace driveline::ecat_master {

/// A number of a slave's identity.
enum class IdentityNumber : std::uint8_t { kVendor, kProduct, kRevision, kSerial, kAlias, kDeviceId };

/// How a planned slave is identified.
enum class KnownBy : std::uint8_t { kPosition, kAlias, kDeviceId };

/// Errors of the bus: one type for each kind, with its facts. Error::facts is one of them.
namespace facts {

/// An entry of a slave's object dictionary.
struct ObjectAddress {
  std::uint16_t index = 0;    ///< of the object
  std::uint8_t subindex = 0;  ///< of its entry
  constexpr bool operator==(const ObjectAddress&) const = default;
};

// Frames and datagrams.

/// Frames did not come back within the retries.
struct NoAnswer {
  std::uint32_t tries = 0;  ///< the first one included
};
/// The port has no carrier.
struct LinkDown {};
/// A datagram was answered by the wrong number of slaves.
struct WorkingCounter {
  std::uint16_t address = 0;   ///< register or memory of the slave
  std::uint16_t expected = 1;  ///< slaves that should have answered
  std::uint16_t received = 0;  ///< slaves that did
};
/// The cycle runs, and no frame of it comes back in time.
struct NoExchange {
  std::chrono::nanoseconds window{0};  ///< how long a cycle waits for its frames
  std::uint32_t cycles = 0;            ///< cycles that have waited in vain
  std::uint32_t late = 0;              ///< frames that came later
};
/// Stopped on request.
struct Cancelled {};
/// The channel through the cycle is still full of frames that were given up.
struct ExchangeFull {};

// The line.

/// No slave answers.
struct NoSlaves {};
/// More slaves than addresses.
struct TooManySlaves {
  std::uint32_t found = 0;  ///< slaves that answer
  std::uint32_t limit = 0;  ///< most that can be addressed
};
/// The slaves' ports fit no tree.
struct PortsFitNoTree {
  std::uint32_t open_ports = 0;  ///< of the slave
};
/// Another device than planned, or than was there at start.
struct IdentityMismatch {
  IdentityNumber number = IdentityNumber::kVendor;  ///< the number that differs
  bool at_least = false;                            ///< `expected` is the least value planned
  bool at_start = false;                            ///< `expected` is the value found at start; else the planned one
  std::uint32_t expected = 0;                       ///< as it should be
  std::uint32_t found = 0;                          ///< as the slave has it
};
/// A planned slave is not on the line.
struct SlaveMissing {
  std::uint16_t plan = 0;                 ///< number of the planned slave
  KnownBy known_by = KnownBy::kPosition;  ///< what `number` is
  std::uint16_t number = 0;               ///< its alias or device ID
  std::uint32_t planned = 0;              ///< slaves in all
  std::uint32_t found = 0;                ///< slaves in all
};
/// A slave that is not planned.
struct SlaveExtra {
  std::uint32_t planned = 0;  ///< slaves in all
  std::uint32_t found = 0;    ///< slaves in all
};
/// Two neighbours have changed places.
struct SlavesSwapped {
  std::uint16_t other = 0;  ///< position of its neighbour
};
/// IN and OUT of a slave are swapped.
struct InOutSwapped {
  std::uint16_t port = 0;  ///< where frames come in
};
/// An alias or device ID that must be unique is not.
struct DuplicateAlias {
  std::uint16_t other = 0;                ///< position of the second slave
  KnownBy known_by = KnownBy::kDeviceId;  ///< what `number` is
  std::uint16_t number = 0;               ///< alias or device ID of both
};
/// A slave has come back, and cannot be told from other missing ones.
struct PlaceUnknown {
  std::uint32_t missing = 0;   ///< missing slaves that it may be
  std::uint32_t returned = 0;  ///< newcomers that may be one of them
};

// EEPROMs; `word` is an address in words.

/// The EEPROM interface stays busy.
struct SiiBusy {
  std::uint16_t word = 0;  ///< that was to be read or written
};
/// The EEPROM interface reports an error.
struct SiiError {
  std::uint16_t word = 0;    ///< that was to be read or written
  std::uint16_t status = 0;  ///< register 0x0502
};
/// EEPROM content cannot be used.
struct SiiContent {
  std::uint16_t word = 0;  ///< first word that cannot be decoded
};
/// Nothing but 0xFF where the configuration should be.
struct SiiBlank {};
/// An EEPROM word reads back as something else than was written.
struct SiiVerify {
  std::uint16_t word = 0;     ///< that was written
  std::uint16_t written = 0;  ///< its value
  std::uint16_t read = 0;     ///< what it holds
};
/// The checksum of the EEPROM's configuration area is wrong.
struct SiiChecksum {
  std::uint8_t right = 0;  ///< of what the configuration area holds
  std::uint8_t found = 0;  ///< in the EEPROM
};

// EtherCAT states.

/// A slave reports an error instead of the requested AL state.
struct StateRefused {
  wire::AlState requested = wire::AlState::kNone;          ///< where the slave was to go
  wire::AlState actual = wire::AlState::kNone;             ///< where it is
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< why, by the slave
  std::optional<ConfigurationFinding> finding{};           ///< the cause that the master has found
};
/// A slave did not reach the requested AL state in time.
struct StateTimeout {
  wire::AlState requested = wire::AlState::kNone;          ///< where the slave was to go
  wire::AlState actual = wire::AlState::kNone;             ///< where it is
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< as it stands in its register
  std::chrono::nanoseconds timeout{0};                     ///< time that it had
};

// Mailboxes and CoE.

/// The slave has no mailbox, or none that knows the protocol.
struct NoMailbox {
  std::optional<wire::MailboxType> protocol{};  ///< that was to be spoken; none: any
};
/// The slave has no mailbox for BOOT.
struct NoBootMailbox {};
/// No mailbox reply in time.
struct MailboxTimeout {
  ObjectAddress object{};               ///< that was asked for
  std::chrono::nanoseconds timeout{0};  ///< that the slave had
};
/// The slave answered with a mailbox error reply.
struct MailboxError {
  ObjectAddress object{};  ///< that was asked for
  std::uint16_t code = 0;  ///< of the error reply
};
/// The slave's mailbox does not decode.
struct MailboxMalformed {
  ObjectAddress object{};  ///< that was asked for
};
/// The slave aborted an SDO transfer.
struct SdoAbort {
  ObjectAddress object{};  ///< that was to be read or written
  wire::SdoAbort code{};   ///< why, by the slave
};
/// An SDO has another size than asked for.
struct SdoSize {
  ObjectAddress object{};      ///< that was read
  std::uint32_t expected = 0;  ///< bytes
  std::uint32_t received = 0;  ///< bytes
};

// Files (FoE).

/// The slave refused a file.
struct FileRefused {
  wire::FoeError code{};  ///< why, by the slave
};
/// Another packet of a file came than the awaited one.
struct FilePacket {
  std::uint32_t expected = 0;  ///< number of the awaited packet
  std::uint32_t received = 0;  ///< number that came
};
/// A slave sends more than is taken of a file.
struct FileSize {
  std::uint64_t limit = 0;  ///< bytes
};
/// The slave was busy with a file for too long.
struct FileBusy {
  std::chrono::nanoseconds waited{0};  ///< since it has moved on
};

// Ethernet (EoE).

/// The slave's description says that it does not know EoE.
struct NoEoe {};
/// The slave refused an EoE service.
struct EoeRefused {
  wire::EoeType service{};   ///< the request
  wire::EoeResult result{};  ///< why, by the slave
};

// Operation data (SoE).

/// An operation datum of a drive that a slave has.
struct SoeDatum {
  std::uint8_t drive = 0;  ///< of the slave, 0 to 7
  wire::Idn idn{};         ///< its number
  constexpr bool operator==(const SoeDatum&) const = default;
};
/// The slave refused an access to an operation datum.
struct SoeRefused {
  SoeDatum datum{};       ///< that was to be read or written
  wire::SoeError code{};  ///< why, by the slave
};
/// An answer is about another operation datum than the one asked for.
struct SoeOther {
  SoeDatum asked{};     ///< as it should be
  SoeDatum answered{};  ///< as it came
};
/// A fragment announces another number of fragments to come than the one before.
struct SoeFragments {
  SoeDatum datum{};            ///< that is being read
  std::uint16_t expected = 0;  ///< still to come
  std::uint16_t received = 0;  ///< as announced
};
/// What came of an operation datum is not what its attribute says.
struct SoeContent {
  SoeDatum datum{};         ///< that was read
  std::uint32_t bytes = 0;  ///< that came
};
/// A procedure command has not come to a good end.
struct SoeCommandEnded {
  SoeDatum datum{};               ///< the command
  wire::SoeCommandState state{};  ///< as it ended
};
/// A procedure command is not over in time.
struct SoeCommandTimeout {
  SoeDatum datum{};                     ///< the command
  std::chrono::nanoseconds timeout{0};  ///< time that it had
};

// Process data.

/// Process data, a datagram or a mailbox is too large for its place.
struct ProcessDataSize {
  std::uint32_t bytes = 0;  ///< bytes of the data
  std::uint32_t limit = 0;  ///< most bytes that fit
};
/// The slave has not enough FMMUs for its process data.
struct TooFewFmmus {
  std::uint32_t needed = 0;   ///< by the process data
  std::uint32_t present = 0;  ///< in the slave
};

}  // namespace facts
}  // namespace driveline::ecat_master
