// Messages for errors of single slaves: EEPROMs, states, mailboxes, process data.
#include <fmt/format.h>

#include "driveline/ecat_master/error/soe_display.hpp"
#include "driveline/wire/mailbox.hpp"
#include "error/sentence.hpp"

namespace driveline::ecat_master {
namespace {

std::string object_text(const facts::ObjectAddress& object) {
  return fmt::format("object {:04X}h:{:02X}", object.index, object.subindex);
}

/// `word` and the object; empty when there is no object.
std::string about(std::string_view word, const facts::ObjectAddress& object) {
  if (object == facts::ObjectAddress{}) return {};
  return fmt::format(" {}{}", word, object_text(object));
}

std::int64_t in_ms(std::chrono::nanoseconds time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

/// Text for a slave that refuses an EoE service.
std::string_view refusal_of(wire::EoeType service) {
  switch (service) {
    case wire::EoeType::kSetIpRequest:
      return "refused the IP parameters with";
    case wire::EoeType::kGetIpRequest:
      return "does not report its IP parameters,";
    case wire::EoeType::kSetFilterRequest:
      return "refused the address filter with";
    default:
      return "does not report its address filter,";
  }
}

/// The operation datum as text: "S-0-0017 of drive 0".
std::string datum_text(const facts::SoeDatum& datum) {
  const auto idn = datum.idn.text();
  return fmt::format("{} of drive {}", std::string_view(idn.data(), idn.size()), datum.drive);
}

/// What a drive lists as invalid: "; S-0-0021 of drive 0 lists S-0-0001".
std::string invalid_text(const facts::InvalidDatum& invalid) {
  const auto idn = invalid.idn.text();
  return fmt::format("; {} lists {}", datum_text({invalid.drive, {invalid.list}}),
                     std::string_view(idn.data(), idn.size()));
}

std::string code_text(wire::AlStatusCode code, std::string_view meaning) {
  return fmt::format("AL status code 0x{:04X} ({})", static_cast<std::uint16_t>(code), meaning);
}

}  // namespace

std::string_view display_text(wire::SoeDisplay display) noexcept {
  switch (display) {
    case wire::SoeDisplay::kBinary:
      return "binary";
    case wire::SoeDisplay::kUnsigned:
      return "unsigned";
    case wire::SoeDisplay::kSigned:
      return "signed";
    case wire::SoeDisplay::kHexadecimal:
      return "hexadecimal";
    case wire::SoeDisplay::kText:
      return "text";
    case wire::SoeDisplay::kIdn:
      return "IDN";
    case wire::SoeDisplay::kFloat:
      return "float";
    case wire::SoeDisplay::kReserved:
      break;
  }
  return "reserved";
}

std::string Sentence::operator()(const facts::SiiBusy& facts) const {
  return fmt::format("{}: EEPROM interface stays busy at word 0x{:04X}", who(), facts.word);
}

std::string Sentence::operator()(const facts::SiiError& facts) const {
  return fmt::format("{}: EEPROM access to word 0x{:04X} failed, status 0x{:04X}", who(), facts.word, facts.status);
}

std::string Sentence::operator()(const facts::SiiContent& facts) const {
  return fmt::format("{}: EEPROM content is not usable at word 0x{:04X}", who(), facts.word);
}

std::string Sentence::operator()(const facts::SiiBlank& /*facts*/) const {
  return fmt::format("{}: EEPROM is blank: all bytes are 0xFF", who());
}

std::string Sentence::operator()(const facts::SiiVerify& facts) const {
  return fmt::format("{}: EEPROM word 0x{:04X} reads back as 0x{:04X} after 0x{:04X} was written", who(), facts.word,
                     facts.read, facts.written);
}

std::string Sentence::operator()(const facts::SiiChecksum& facts) const {
  return fmt::format("{}: EEPROM checksum is 0x{:02X}, 0x{:02X} is expected: the slave ignores the content", who(),
                     facts.found, facts.right);
}

std::string Sentence::operator()(const facts::StateRefused& facts) const {
  // The slave refuses without a code.
  const bool silent = facts.code == wire::AlStatusCode::kNoError;
  // A refusing slave sets the error flag; it may even be in the requested state.
  return fmt::format("{}: requested {}, is in {} + error, {}{}{}", who(), wire::to_text(facts.requested),
                     wire::to_text(facts.actual),
                     code_text(facts.code, silent ? "the slave gives no reason" : wire::to_text(facts.code)),
                     facts.finding ? "; " + describe(*facts.finding) : std::string{},
                     facts.invalid.list != 0 ? invalid_text(facts.invalid) : std::string{});
}

std::string Sentence::operator()(const facts::StateTimeout& facts) const {
  return fmt::format("{}: requested {}, is in {} and did not change within {} ms, {}", who(),
                     wire::to_text(facts.requested), wire::to_text(facts.actual), in_ms(facts.timeout),
                     code_text(facts.code, wire::to_text(facts.code)));
}

std::string Sentence::operator()(const facts::NoMailbox& facts) const {
  if (!facts.protocol) return fmt::format("{}: has no mailbox", who());
  return fmt::format("{}: has no {} mailbox", who(), wire::to_text(*facts.protocol));
}

std::string Sentence::operator()(const facts::NoBootMailbox& /*facts*/) const {
  return fmt::format("{}: has no mailbox for BOOT: its EEPROM defines none for the bootstrap state", who());
}

std::string Sentence::operator()(const facts::MailboxTimeout& facts) const {
  auto text =
      fmt::format("{}: no mailbox reply{} within {} ms", who(), about("for ", facts.object), in_ms(facts.timeout));
  if (facts.dropped != 0) {
    text += fmt::format("; {} dropped, with the counter and content of the previous message",
                        facts.dropped == 1 ? "1 reply was" : fmt::format("{} replies were", facts.dropped));
  }
  return text;
}

std::string Sentence::operator()(const facts::MailboxError& facts) const {
  return fmt::format("{}: answered{} with mailbox error 0x{:04X} ({})", who(), about("", facts.object), facts.code,
                     wire::to_text(static_cast<wire::MailboxErrorCode>(facts.code)));
}

std::string Sentence::operator()(const facts::MailboxMalformed& facts) const {
  return fmt::format("{}: sent a malformed mailbox{}", who(), about("for ", facts.object));
}

std::string Sentence::operator()(const facts::SdoAbort& facts) const {
  return fmt::format("{}: {} aborted with 0x{:08X} ({})", who(), object_text(facts.object),
                     static_cast<std::uint32_t>(facts.code), wire::to_text(facts.code));
}

std::string Sentence::operator()(const facts::SdoSize& facts) const {
  return fmt::format("{}: {} has {} bytes, {} were expected", who(), object_text(facts.object), facts.received,
                     facts.expected);
}

std::string Sentence::operator()(const facts::FileRefused& facts) const {
  return fmt::format("{}: refused the file with FoE error 0x{:04X} ({})", who(), static_cast<std::uint32_t>(facts.code),
                     wire::to_text(facts.code));
}

std::string Sentence::operator()(const facts::FilePacket& facts) const {
  return fmt::format("{}: packet {} of the file was expected, {} came", who(), facts.expected, facts.received);
}

std::string Sentence::operator()(const facts::FileSize& facts) const {
  return fmt::format("{}: sends more than the {} bytes of the file that are accepted", who(), facts.limit);
}

std::string Sentence::operator()(const facts::FileBusy& facts) const {
  return fmt::format("{}: was busy with the file for {} ms without progress", who(), in_ms(facts.waited));
}

std::string Sentence::operator()(const facts::NoEoe& /*facts*/) const {
  return fmt::format("{}: does not support EoE according to its description", who());
}

std::string Sentence::operator()(const facts::EoeRefused& facts) const {
  return fmt::format("{}: {} EoE result 0x{:04X} ({})", who(), refusal_of(facts.service),
                     static_cast<std::uint16_t>(facts.result), wire::to_text(facts.result));
}

std::string Sentence::operator()(const facts::SoeRefused& facts) const {
  return fmt::format("{}: refused {} with SoE error 0x{:04X} ({})", who(), datum_text(facts.datum),
                     static_cast<std::uint16_t>(facts.code), wire::to_text(facts.code));
}

std::string Sentence::operator()(const facts::SoeOther& facts) const {
  return fmt::format("{}: request for {} was answered with {}", who(), datum_text(facts.asked),
                     datum_text(facts.answered));
}

std::string Sentence::operator()(const facts::SoeFragments& facts) const {
  return fmt::format("{}: {} further fragments of {} were expected, {} are announced", who(), facts.expected,
                     datum_text(facts.datum), facts.received);
}

std::string Sentence::operator()(const facts::SoeContent& facts) const {
  return fmt::format("{}: the {} bytes of {} do not match its attribute", who(), facts.bytes, datum_text(facts.datum));
}

std::string Sentence::operator()(const facts::SoeForm& facts) const {
  return fmt::format("{}: the value for {} does not fit: {} of {} byte{}, {}, is expected", who(),
                     datum_text(facts.datum), facts.list ? "a list of elements" : "one number", facts.element_bytes,
                     facts.element_bytes == 1 ? "" : "s", display_text(facts.display));
}

std::string Sentence::operator()(const facts::SoeListLength& facts) const {
  return fmt::format("{}: the list for {} has {} bytes, the drive has room for {}", who(), datum_text(facts.datum),
                     facts.bytes, facts.limit);
}

std::string Sentence::operator()(const facts::SoeLimit& facts) const {
  return fmt::format("{}: refused {} for {}, {} limit {}", who(), facts.value, datum_text(facts.datum),
                     facts.above ? "above its upper" : "below its lower", facts.limit);
}

std::string Sentence::operator()(const facts::SoeNotKept& facts) const {
  return fmt::format("{}: {}{} reads back as {} after {} was written", who(),
                     facts.element == 0 ? std::string{} : fmt::format("element {} of ", facts.element),
                     datum_text(facts.datum), facts.read, facts.written);
}

std::string Sentence::operator()(const facts::SoeCommandEnded& facts) const {
  return fmt::format("{}: the procedure command {} ended in data state 0x{:04X} ({})", who(), datum_text(facts.datum),
                     static_cast<std::uint16_t>(facts.state), wire::to_text(facts.state));
}

std::string Sentence::operator()(const facts::SoeCommandTimeout& facts) const {
  return fmt::format("{}: the procedure command {} did not end within {} ms", who(), datum_text(facts.datum),
                     in_ms(facts.timeout));
}

std::string Sentence::operator()(const facts::ProcessDataSize& facts) const {
  return fmt::format("{}: {} bytes of process data do not fit, the limit is {}", who(), facts.bytes, facts.limit);
}

std::string Sentence::operator()(const facts::TooFewFmmus& facts) const {
  return fmt::format("{}: its process data need {} FMMUs, it has {}", who(), facts.needed, facts.present);
}

}  // namespace driveline::ecat_master
