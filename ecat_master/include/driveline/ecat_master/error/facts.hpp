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

/// Errors of the bus: one type per kind, with its details. Error::facts is one of them.
namespace facts {

/// An entry of a slave's object dictionary.
struct ObjectAddress {
  std::uint16_t index = 0;    ///< index of the object
  std::uint8_t subindex = 0;  ///< sub-index of the entry
  constexpr bool operator==(const ObjectAddress&) const = default;
};

/// An operation datum of a drive of a slave.
struct SoeDatum {
  std::uint8_t drive = 0;  ///< drive of the slave, 0 to 7
  wire::Idn idn{};         ///< number of the operation datum
  constexpr bool operator==(const SoeDatum&) const = default;
};
/// An operation datum that a drive lists as the reason why it does not change its phase.
struct InvalidDatum {
  std::uint8_t drive = 0;  ///< drive of the slave, 0 to 7
  std::uint8_t list =
      0;            ///< number of the list: 21, 22 or 23 for S-0-0021, S-0-0022 or S-0-0023; 0: no drive lists any
  wire::Idn idn{};  ///< the operation datum
  constexpr bool operator==(const InvalidDatum&) const = default;
};

// Frames and datagrams.

/// Frames did not return within the retries.
struct NoAnswer {
  std::uint32_t tries = 0;  ///< number of tries, including the first
};
/// The port has no carrier.
struct LinkDown {};
/// A datagram was answered by the wrong number of slaves.
struct WorkingCounter {
  std::uint16_t address = 0;   ///< register or memory of the slave
  std::uint16_t expected = 1;  ///< slaves that should have answered
  std::uint16_t received = 0;  ///< slaves that answered
};
/// The cycle runs, but none of its frames returns in time.
struct NoExchange {
  std::chrono::nanoseconds window{0};  ///< time for which a cycle waits for its frames
  std::uint32_t cycles = 0;            ///< cycles that waited without result
  std::uint32_t late = 0;              ///< frames that returned later
};
/// Stopped on request.
struct Cancelled {};
/// The channel through the cycle is still full of abandoned frames.
struct ExchangeFull {};

// The line.

/// No slave answers.
struct NoSlaves {};
/// More slaves than station addresses.
struct TooManySlaves {
  std::uint32_t found = 0;  ///< number of slaves that answer
  std::uint32_t limit = 0;  ///< most slaves that can be addressed
};
/// No tree explains the slaves' ports.
struct PortsFitNoTree {
  std::uint32_t open_ports = 0;  ///< open ports of the slave
};
/// Another device than planned, or than was present at the start.
struct IdentityMismatch {
  IdentityNumber number = IdentityNumber::kVendor;  ///< the number that differs
  bool at_least = false;                            ///< `expected` is a lower limit
  bool at_start = false;                            ///< `expected` is the value found at start; else the planned one
  std::uint32_t expected = 0;                       ///< expected value
  std::uint32_t found = 0;                          ///< value of the slave
};
/// A planned slave is not on the line.
struct SlaveMissing {
  std::uint16_t plan = 0;                 ///< number of the planned slave
  KnownBy known_by = KnownBy::kPosition;  ///< meaning of `number`
  std::uint16_t number = 0;               ///< alias or device ID of the planned slave
  std::uint32_t planned = 0;              ///< number of planned slaves
  std::uint32_t found = 0;                ///< number of slaves found
};
/// A slave that is not planned.
struct SlaveExtra {
  std::uint32_t planned = 0;  ///< number of planned slaves
  std::uint32_t found = 0;    ///< number of slaves found
};
/// Two adjacent slaves are swapped.
struct SlavesSwapped {
  std::uint16_t other = 0;  ///< position of the adjacent slave
};
/// IN and OUT of a slave are swapped.
struct InOutSwapped {
  std::uint16_t port = 0;  ///< port where frames enter
};
/// An alias or device ID that must be unique exists twice.
struct DuplicateAlias {
  std::uint16_t other = 0;                ///< position of the second slave
  KnownBy known_by = KnownBy::kDeviceId;  ///< meaning of `number`
  std::uint16_t number = 0;               ///< alias or device ID of both slaves
};
/// A slave has returned but cannot be distinguished from other missing slaves.
struct PlaceUnknown {
  std::uint32_t missing = 0;   ///< number of missing slaves that it may be
  std::uint32_t returned = 0;  ///< number of new slaves that may be one of them
};

// EEPROMs; `word` is a word address.

/// The EEPROM interface stays busy.
struct SiiBusy {
  std::uint16_t word = 0;  ///< word to be read or written
};
/// The EEPROM interface reports an error.
struct SiiError {
  std::uint16_t word = 0;    ///< word to be read or written
  std::uint16_t status = 0;  ///< register 0x0502
};
/// The EEPROM content cannot be used.
struct SiiContent {
  std::uint16_t word = 0;  ///< first word that cannot be decoded
};
/// Only 0xFF where the configuration should be.
struct SiiBlank {};
/// An EEPROM word reads back differently than written.
struct SiiVerify {
  std::uint16_t word = 0;     ///< word that was written
  std::uint16_t written = 0;  ///< written value
  std::uint16_t read = 0;     ///< value read back
};
/// The checksum of the EEPROM's configuration area is wrong.
struct SiiChecksum {
  std::uint8_t right = 0;  ///< checksum of the configuration area's content
  std::uint8_t found = 0;  ///< checksum in the EEPROM
};

// EtherCAT states.

/// A slave reports an error instead of the requested AL state.
struct StateRefused {
  wire::AlState requested = wire::AlState::kNone;          ///< requested state
  wire::AlState actual = wire::AlState::kNone;             ///< actual state
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< reason reported by the slave
  std::optional<ConfigurationFinding> finding{};           ///< cause found by the master
  InvalidDatum invalid{};                                  ///< first cause that a drive of the slave names
};
/// A slave did not reach the requested AL state in time.
struct StateTimeout {
  wire::AlState requested = wire::AlState::kNone;          ///< requested state
  wire::AlState actual = wire::AlState::kNone;             ///< actual state
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;  ///< content of the AL status code register
  std::chrono::nanoseconds timeout{0};                     ///< time allowed
};

// Mailboxes and CoE.

/// The slave has no mailbox, or none that supports the protocol.
struct NoMailbox {
  std::optional<wire::MailboxType> protocol{};  ///< required protocol; empty: any
};
/// The slave has no mailbox for BOOT.
struct NoBootMailbox {};
/// No mailbox reply in time.
struct MailboxTimeout {
  ObjectAddress object{};               ///< object of the request
  std::chrono::nanoseconds timeout{0};  ///< time allowed
  std::uint32_t dropped = 0;            ///< replies dropped as repetitions: counter and content of the previous message
};
/// The slave answered with a mailbox error reply.
struct MailboxError {
  ObjectAddress object{};  ///< object of the request
  std::uint16_t code = 0;  ///< code of the error reply
};
/// The slave's mailbox message cannot be decoded.
struct MailboxMalformed {
  ObjectAddress object{};  ///< object of the request
};
/// The slave aborted an SDO transfer.
struct SdoAbort {
  ObjectAddress object{};  ///< object to be read or written
  wire::SdoAbort code{};   ///< reason reported by the slave
};
/// An SDO has another size than requested.
struct SdoSize {
  ObjectAddress object{};      ///< object that was read
  std::uint32_t expected = 0;  ///< bytes
  std::uint32_t received = 0;  ///< bytes
};

// Files (FoE).

/// The slave refused a file.
struct FileRefused {
  wire::FoeError code{};  ///< reason reported by the slave
};
/// Another packet of a file arrived than the expected one.
struct FilePacket {
  std::uint32_t expected = 0;  ///< number of the expected packet
  std::uint32_t received = 0;  ///< number of the received packet
};
/// A slave sends more than the largest accepted file.
struct FileSize {
  std::uint64_t limit = 0;  ///< limit in bytes
};
/// The slave was busy too long with a file.
struct FileBusy {
  std::chrono::nanoseconds waited{0};  ///< time since its last progress
};

// Ethernet (EoE).

/// According to its description the slave does not support EoE.
struct NoEoe {};
/// The slave refused an EoE service.
struct EoeRefused {
  wire::EoeType service{};   ///< the request
  wire::EoeResult result{};  ///< reason reported by the slave
};

// Operation data (SoE).

/// The slave refused an access to an operation datum.
struct SoeRefused {
  SoeDatum datum{};       ///< operation datum to be read or written
  wire::SoeError code{};  ///< reason reported by the slave
};
/// An answer is about another operation datum than the requested one.
struct SoeOther {
  SoeDatum asked{};     ///< requested operation datum
  SoeDatum answered{};  ///< operation datum in the answer
};
/// A fragment announces a number of further fragments that does not match the previous fragment.
struct SoeFragments {
  SoeDatum datum{};            ///< operation datum being read
  std::uint16_t expected = 0;  ///< expected number of fragments to come
  std::uint16_t received = 0;  ///< announced number of fragments to come
};
/// The received data of an operation datum do not match its attribute.
struct SoeContent {
  SoeDatum datum{};         ///< operation datum read
  std::uint32_t bytes = 0;  ///< bytes received
};
/// The planned value of an operation datum has another form than its attribute says.
struct SoeForm {
  SoeDatum datum{};                                        ///< operation datum to be written
  bool list = false;                                       ///< it is a list
  std::uint8_t element_bytes = 0;                          ///< bytes of the value, or of each element
  wire::SoeDisplay display = wire::SoeDisplay::kUnsigned;  ///< its display format
};
/// The planned list is longer than the drive's list can be.
struct SoeListLength {
  SoeDatum datum{};         ///< operation datum to be written
  std::uint32_t bytes = 0;  ///< bytes of the planned list
  std::uint32_t limit = 0;  ///< most bytes of the list in the drive
};
/// A drive refused a number outside the limits of the operation datum.
struct SoeLimit {
  SoeDatum datum{};    ///< operation datum that was written
  bool above = false;  ///< the number is above `limit`; else below
  double value = 0.0;  ///< number that was written
  double limit = 0.0;  ///< limit that the drive tells
};
/// A drive accepted a value, but keeps another one.
struct SoeNotKept {
  SoeDatum datum{};           ///< operation datum that was written
  std::uint16_t element = 0;  ///< first element that differs, counted from 0
  double written = 0.0;       ///< value that was written; 0 where the list has ended
  double read = 0.0;          ///< value that was read back; 0 where the list has ended
};
/// A procedure command has not ended successfully.
struct SoeCommandEnded {
  SoeDatum datum{};               ///< the command
  wire::SoeCommandState state{};  ///< final data state
};
/// A procedure command has not ended in time.
struct SoeCommandTimeout {
  SoeDatum datum{};                     ///< the command
  std::chrono::nanoseconds timeout{0};  ///< time allowed
};

// Process data.

/// Process data, a datagram or a mailbox message is too large.
struct ProcessDataSize {
  std::uint32_t bytes = 0;  ///< bytes of the data
  std::uint32_t limit = 0;  ///< most bytes that fit
};
/// The slave has not enough FMMUs for its process data.
struct TooFewFmmus {
  std::uint32_t needed = 0;   ///< FMMUs needed by the process data
  std::uint32_t present = 0;  ///< FMMUs of the slave
};

}  // namespace facts
}  // namespace driveline::ecat_master
