#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <type_traits>

#include "driveline/wire/al.hpp"
#include "driveline/wire/al_status_code.hpp"
#include "driveline/wire/sdo_abort.hpp"

namespace driveline::ecat_master {

/// What went wrong on the bus. Error::detail holds the facts that belong to each kind.
enum class ErrorKind : std::uint8_t {
  kNoAnswer,           ///< frames did not come back within the retries
  kLinkDown,           ///< the port has no carrier
  kWorkingCounter,     ///< a datagram was answered by the wrong number of slaves
  kNoSlaves,           ///< nothing on the line
  kTooManySlaves,      ///< more slaves than addresses
  kTopology,           ///< the slaves' ports fit no tree
  kSiiBusy,            ///< EEPROM interface stays busy
  kSiiError,           ///< EEPROM interface reports an error
  kSiiContent,         ///< EEPROM content cannot be used; code: 0 or kSiiBlank
  kSiiVerify,          ///< an EEPROM word reads back as something else than was written
  kStateRefused,       ///< a slave reports an error instead of the requested AL state
  kStateTimeout,       ///< a slave did not reach the requested AL state in time
  kNoMailbox,          ///< the slave has no mailbox, or not the protocol; requested BOOT: none for that state
  kMailboxTimeout,     ///< no mailbox reply in time
  kMailboxError,       ///< the slave answered with a mailbox error reply
  kMailboxMalformed,   ///< the slave's mailbox does not decode
  kSdoAbort,           ///< the slave aborted an SDO transfer
  kSdoSize,            ///< an SDO has another size than asked for
  kSiiChecksum,        ///< the checksum of the EEPROM's configuration area is wrong
  kIdentityMismatch,   ///< another device than planned; subindex 1: `expected` is the least that is planned; code 1:
                       ///< than was there at start
  kSlaveMissing,       ///< planned slave number `extra` is not on the line; expected, received: slaves in all
  kSlavesSwapped,      ///< two neighbours have changed places
  kWiring,             ///< IN and OUT of a slave are swapped
  kDuplicateAlias,     ///< an alias or device ID that must be unique is not
  kSlaveExtra,         ///< a slave that is not planned; expected, received: slaves in all
  kProcessDataSize,    ///< process data does not fit (frame, sync manager, PDO)
  kNoExchange,         ///< the cycle runs, and no frame of it comes back in time
  kAxisNotEnabled,     ///< an axis did not reach Operation enabled
  kAxisFault,          ///< an axis reports a fault
  kCommunicationLost,  ///< the cyclic exchange broke down
  kClock,              ///< distributed clocks; code: dc::ClockFault
  kCancelled,          ///< stopped on request
  kExchangeFull,       ///< frames that were given up before still fill the way through the cycle
  kPlaceUnknown,       ///< a slave has come back, and nothing tells which of the missing ones it is
};

/// Error::address of kIdentityMismatch: which number is another one than planned.
enum class IdentityNumber : std::uint16_t { kVendor, kProduct, kRevision, kSerial, kAlias, kDeviceId };

/// Error::subindex of kSlaveMissing and kDuplicateAlias: what Error::address is.
enum class KnownBy : std::uint8_t { kPosition, kAlias, kDeviceId };

/// Error::code of kSiiContent: nothing but 0xFF where the configuration should be.
inline constexpr std::uint32_t kSiiBlank = 1;

/// An error with its facts; 24 bytes, trivially copyable, made without allocation. `describe()` makes the sentence.
///
/// Fields that do not apply to a kind are zero; `slave` is kNoSlave when no slave can be named.
struct Error {
  /// `slave`: it is about the line as a whole.
  static constexpr std::uint16_t kNoSlave = 0xFFFF;

  ErrorKind kind = ErrorKind::kNoAnswer;           ///< what went wrong
  std::uint8_t subindex = 0;                       ///< of the object at `address`, for CoE
  wire::AlState requested = wire::AlState::kNone;  ///< for state changes
  wire::AlState actual = wire::AlState::kNone;     ///< for state changes
  std::uint16_t slave = kNoSlave;                  ///< position on the line, 0 = first
  std::uint16_t address = 0;                       ///< register, object index or EEPROM word, as the kind says
  std::uint32_t expected = 0;                      ///< working counter, size, identity ... that was expected
  std::uint32_t received = 0;                      ///< the same as found
  std::uint32_t code = 0;   ///< AL status code, SDO abort code, CiA 402 error code, mailbox error code
  std::uint32_t extra = 0;  ///< second fact (time in us, sync manager number)
};
static_assert(std::is_trivially_copyable_v<Error> && sizeof(Error) <= 24);

/// A value, or why there is none.
template <typename T>
using Result = tl::expected<T, Error>;

/// The error as one sentence with all of its facts. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const Error& error);

}  // namespace driveline::ecat_master
