#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <type_traits>
#include <variant>

#include "driveline/ecat_master/error/clock_facts.hpp"
#include "driveline/ecat_master/error/facts.hpp"

namespace driveline::ecat_master {

/// The details of an error; the alternative is its kind.
using ErrorFacts = std::variant<
    facts::NoAnswer, facts::LinkDown, facts::WorkingCounter, facts::NoExchange, facts::Cancelled, facts::ExchangeFull,
    facts::NoSlaves, facts::TooManySlaves, facts::PortsFitNoTree, facts::IdentityMismatch, facts::SlaveMissing,
    facts::SlaveExtra, facts::SlavesSwapped, facts::InOutSwapped, facts::DuplicateAlias, facts::PlaceUnknown,
    facts::SiiBusy, facts::SiiError, facts::SiiContent, facts::SiiBlank, facts::SiiVerify, facts::SiiChecksum,
    facts::StateRefused, facts::StateTimeout, facts::NoMailbox, facts::NoBootMailbox, facts::MailboxTimeout,
    facts::MailboxError, facts::MailboxMalformed, facts::SdoAbort, facts::SdoSize, facts::FileRefused,
    facts::FilePacket, facts::FileSize, facts::FileBusy, facts::NoEoe, facts::EoeRefused, facts::SoeRefused,
    facts::SoeOther, facts::SoeFragments, facts::SoeContent, facts::SoeForm, facts::SoeListLength, facts::SoeLimit,
    facts::SoeNotKept, facts::SoeCommandEnded, facts::SoeCommandTimeout, facts::ProcessDataSize, facts::TooFewFmmus,
    facts::NoClocks, facts::NoClock, facts::ReferenceWithoutClock, facts::BeforeReference, facts::NoClockMode,
    facts::NotInPreOp, facts::ContradictingDelays, facts::NoReceiveTimes, facts::StartTimePast, facts::SyncRegister,
    facts::SyncObject, facts::SyncCycleRange, facts::SyncCycleBase, facts::SyncCycleAndPeriod, facts::SyncShift,
    facts::Sync1WithoutSync0, facts::Sync1Cycle, facts::Sync1Shift, facts::NoCommonCycle, facts::FrameLead,
    facts::NotLocked, facts::NotSynchronised>;

/// An error with its details; 40 bytes, trivially copyable, made without allocation. `describe()` makes the message.
///
///     return tl::unexpected(Error{facts::WorkingCounter{.address = 0x0130, .received = 0}, slave.position});
///     if (error.is<facts::WorkingCounter>()) ...
///     if (const auto* abort = error.as<facts::SdoAbort>()) use(abort->code);
struct Error {
  /// Value of `slave` for an error of the whole line.
  static constexpr std::uint16_t kNoSlave = 0xFFFF;

  ErrorFacts facts;                ///< kind and facts
  std::uint16_t slave = kNoSlave;  ///< position on the line, 0 = first

  /// Whether the error is of the kind. \rtsafe
  template <typename Kind>
  [[nodiscard]] constexpr bool is() const noexcept {
    return std::holds_alternative<Kind>(facts);
  }
  /// The details if the error is of the kind, else null. \rtsafe
  template <typename Kind>
  [[nodiscard]] constexpr const Kind* as() const noexcept {
    return std::get_if<Kind>(&facts);
  }
};
static_assert(std::is_trivially_copyable_v<Error> && sizeof(Error) <= 40);

/// A value or an Error.
template <typename T>
using Result = tl::expected<T, Error>;

/// The error as one sentence with all its details. Allocates: not for the cycle.
[[nodiscard]] std::string describe(const Error& error);

}  // namespace driveline::ecat_master
