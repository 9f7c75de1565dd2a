#include "driveline/ecat_master/error.hpp"

#include <fmt/format.h>

#include "driveline/ecat_master/cia402/error_code.hpp"
#include "driveline/ecat_master/error/clock_fault.hpp"
#include "driveline/ecat_master/error/configuration_finding.hpp"
#include "driveline/wire/mailbox.hpp"

namespace driveline::ecat_master {
namespace {

std::string who(const Error& e) {
  return e.slave == Error::kNoSlave ? std::string("the line") : fmt::format("slave {}", e.slave);
}

std::string answering(std::uint32_t count) {
  return count == 1 ? std::string("1 slave answers") : fmt::format("{} slaves answer", count);
}

std::string al_code(const Error& e) {
  const auto code = static_cast<wire::AlStatusCode>(e.code);
  // A slave that refuses and leaves the code at zero.
  const bool silent = e.kind == ErrorKind::kStateRefused && code == wire::AlStatusCode::kNoError;
  return fmt::format("AL status code 0x{:04X} ({})", e.code,
                     silent ? std::string_view("the slave gives no reason") : wire::to_text(code));
}

std::string al_states(const Error& e) {
  // Whoever refuses sets the error flag; it may well be in the state that was asked for.
  return fmt::format("asked for {}, is in {}{}", wire::to_text(e.requested), wire::to_text(e.actual),
                     e.kind == ErrorKind::kStateRefused ? " + error" : "");
}

/// What was found out about a refused transition.
std::string explanation(const Error& e) {
  const auto finding = finding_of(e);
  return finding ? "; " + describe(*finding) : std::string{};
}

std::string object(const Error& e) {
  return fmt::format("object {:04X}h:{:02X}", e.address, e.subindex);
}

std::string_view to_text(IdentityNumber number) {
  switch (number) {
    case IdentityNumber::kVendor:
      return "vendor id";
    case IdentityNumber::kProduct:
      return "product code";
    case IdentityNumber::kRevision:
      return "revision";
    case IdentityNumber::kSerial:
      return "serial number";
    case IdentityNumber::kAlias:
      return "alias";
    case IdentityNumber::kDeviceId:
      return "device ID";
  }
  return "identity";
}

std::string known_by(const Error& e) {
  return fmt::format("{} {}", static_cast<KnownBy>(e.subindex) == KnownBy::kAlias ? "alias" : "device ID", e.address);
}

/// How many there are and should be, where that says something.
std::string slave_counts(const Error& e) {
  return e.expected == e.received
             ? std::string{}
             : fmt::format("; {}, {} planned", answering(e.received),
                           e.expected == 1 ? std::string("1 is") : fmt::format("{} are", e.expected));
}

std::string describe_slave_facts(const Error& e) {
  switch (e.kind) {
    case ErrorKind::kStateRefused:
      return fmt::format("{}: {}, {}{}", who(e), al_states(e), al_code(e), explanation(e));
    case ErrorKind::kStateTimeout:
      return fmt::format("{}: {} and did not change within {} ms, {}", who(e), al_states(e), e.extra / 1000,
                         al_code(e));
    case ErrorKind::kSiiBusy:
      return fmt::format("{}: EEPROM interface stays busy at word 0x{:04X}", who(e), e.address);
    case ErrorKind::kSiiError:
      return fmt::format("{}: EEPROM access to word 0x{:04X} failed, status 0x{:04X}", who(e), e.address, e.code);
    case ErrorKind::kSiiContent:
      if (e.code == kSiiBlank) return fmt::format("{}: EEPROM is blank, it holds nothing but 0xFF", who(e));
      return fmt::format("{}: EEPROM content is not usable at word 0x{:04X}", who(e), e.address);
    case ErrorKind::kSiiVerify:
      return fmt::format("{}: EEPROM word 0x{:04X} reads back as 0x{:04X} after 0x{:04X} was written", who(e),
                         e.address, e.received, e.expected);
    case ErrorKind::kIdentityMismatch:
      return fmt::format("{}: {} is 0x{:08X} but {}0x{:08X} {}", who(e),
                         to_text(static_cast<IdentityNumber>(e.address)), e.received, e.subindex == 1 ? ">= " : "",
                         e.expected, e.code == 1 ? "was there at start" : "is planned");
    case ErrorKind::kPlaceUnknown:
      return fmt::format("{}: of {} that were missing {} came back, and neither wiring nor serial number tells which",
                         who(e), e.expected, e.received);
    case ErrorKind::kSiiChecksum:
      return fmt::format("{}: EEPROM checksum is 0x{:02X}, 0x{:02X} would be right: the slave does not use its content",
                         who(e), e.received, e.expected);
    case ErrorKind::kSlavesSwapped:
      return fmt::format("{} and slave {} have changed places", who(e), e.extra);
    case ErrorKind::kWiring:
      return fmt::format("{}: IN and OUT are swapped, frames come in at port {}", who(e), e.extra);
    case ErrorKind::kDuplicateAlias:
      return fmt::format("{} and slave {} both answer to {}", who(e), e.extra, known_by(e));
    case ErrorKind::kProcessDataSize:
      if (e.code == 1) {
        return fmt::format("{}: its process data need {} FMMUs, it has {}", who(e), e.received, e.expected);
      }
      return fmt::format("{}: {} bytes of process data do not fit, the limit is {}", who(e), e.received, e.expected);
    default:
      return {};
  }
}

std::string describe_mailbox(const Error& e) {
  switch (e.kind) {
    case ErrorKind::kNoMailbox:
      if (e.requested == wire::AlState::kBootstrap) {
        return fmt::format("{}: has no mailbox for BOOT: its EEPROM names none for the bootstrap state", who(e));
      }
      return fmt::format("{}: has no CoE mailbox", who(e));
    case ErrorKind::kMailboxTimeout:
      return fmt::format("{}: no mailbox reply for {} within {} ms", who(e), object(e), e.extra / 1000);
    case ErrorKind::kMailboxError:
      return fmt::format("{}: answered {} with mailbox error 0x{:04X}", who(e), object(e), e.code);
    case ErrorKind::kMailboxMalformed:
      return fmt::format("{}: sent a malformed mailbox for {}", who(e), object(e));
    case ErrorKind::kSdoAbort:
      return fmt::format("{}: {} aborted with 0x{:08X} ({})", who(e), object(e), e.code,
                         wire::to_text(static_cast<wire::SdoAbort>(e.code)));
    case ErrorKind::kSdoSize:
      return fmt::format("{}: {} has {} bytes, {} were expected", who(e), object(e), e.received, e.expected);
    default:
      return {};
  }
}

}  // namespace

std::string describe(const Error& e) {
  switch (e.kind) {
    case ErrorKind::kNoAnswer:
      return fmt::format("{}: no answer to a frame after {} tries", who(e), e.expected);
    case ErrorKind::kLinkDown:
      return "the port has no link";
    case ErrorKind::kWorkingCounter:
      return fmt::format("{}: working counter {} instead of {} at address 0x{:04X}", who(e), e.received, e.expected,
                         e.address);
    case ErrorKind::kNoSlaves:
      return "no slave answers on the line";
    case ErrorKind::kTooManySlaves:
      return fmt::format("{}, the limit is {}", answering(e.received), e.expected);
    case ErrorKind::kTopology:
      return fmt::format("{}: its {} open ports fit no tree of the slaves that answer", who(e), e.expected);
    case ErrorKind::kSlaveExtra:
      return fmt::format("{} is not planned{}", who(e), slave_counts(e));
    case ErrorKind::kSlaveMissing:
      return fmt::format(
          "planned slave {}{} is not on the line{}", e.extra,
          static_cast<KnownBy>(e.subindex) == KnownBy::kPosition ? std::string{} : fmt::format(" ({})", known_by(e)),
          slave_counts(e));
    case ErrorKind::kNoExchange:
      return fmt::format("no cyclic frame came back within the {} us that its cycle waits, in {} cycles; {} came later",
                         e.expected / 1000, e.received, e.extra);
    case ErrorKind::kAxisNotEnabled:
      return fmt::format("axis {}: not in Operation enabled within {} ms, status word 0x{:04X}", e.slave,
                         e.extra / 1000, e.received);
    case ErrorKind::kAxisFault:
      return fmt::format("axis {}: fault {}, status word 0x{:04X}", e.slave,
                         cia402::error_text(static_cast<std::uint16_t>(e.code)), e.received);
    case ErrorKind::kCommunicationLost:
      return fmt::format("communication lost: {} cycles in a row without valid process data", e.received);
    case ErrorKind::kClock:
      return dc::describe_clock_error(e);
    case ErrorKind::kCancelled:
      return "stopped on request";
    case ErrorKind::kExchangeFull:
      return "the way through the cycle is full of frames that were given up; the cycle may have stopped";
    case ErrorKind::kNoMailbox:
    case ErrorKind::kMailboxTimeout:
    case ErrorKind::kMailboxError:
    case ErrorKind::kMailboxMalformed:
    case ErrorKind::kSdoAbort:
    case ErrorKind::kSdoSize:
      return describe_mailbox(e);
    default:
      return describe_slave_facts(e);
  }
}

}  // namespace driveline::ecat_master
