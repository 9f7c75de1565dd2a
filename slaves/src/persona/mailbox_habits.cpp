#include "persona/mailbox_habits.hpp"

#include <algorithm>

#include "driveline/wire/mailbox.hpp"

namespace driveline::slaves {
namespace {

using Kind = PersonaKind;
using std::chrono::milliseconds;
using wire::CoeHeader;
using wire::CoeService;
using wire::MailboxHeader;
using wire::SdoHeader;

constexpr std::size_t kServiceAt = MailboxHeader::kSize;
constexpr std::size_t kSdoAt = kServiceAt + CoeHeader::kSize;
constexpr std::size_t kSdoDataAt = kSdoAt + 4;  // after command, index and sub-index
constexpr std::size_t kCounterByte = 5;
/// An emergency of a drive whose DC link voltage is too low at power-on (CiA 402, error code 3220h; error register bit
/// 2, voltage).
constexpr wire::Emergency kUndervoltage{0x3220, 0x04, {}};

/// Returns the counter of a message, 1 to 7; 0: not used.
std::uint8_t counter_of(std::span<const std::byte> mail) noexcept {
  return static_cast<std::uint8_t>(std::to_integer<unsigned>(mail[kCounterByte]) >> 4U & 7U);
}

std::uint8_t command_byte(wire::SdoRequestCommand specifier) noexcept {
  return static_cast<std::uint8_t>(static_cast<unsigned>(specifier) << 5U);
}

/// Returns a mailbox message of CoE with 8 bytes after the CoE header; its counter is set when it is sent.
std::vector<std::byte> coe_message(CoeService service, std::uint16_t address) {
  std::vector<std::byte> mail(kSdoAt + SdoHeader::kSize);
  MailboxHeader header;
  header.length = static_cast<std::uint16_t>(CoeHeader::kSize + SdoHeader::kSize);
  header.address = address;
  header.type = wire::MailboxType::kCoe;
  header.encode(std::span(mail).first<MailboxHeader::kSize>());
  CoeHeader{0, service}.encode(std::span(mail).subspan<kServiceAt, CoeHeader::kSize>());
  return mail;
}

std::vector<std::byte> sdo_message(CoeService service, const SdoHeader& sdo, std::uint16_t address = 0) {
  auto mail = coe_message(service, address);
  sdo.encode(std::span(mail).subspan<kSdoAt, SdoHeader::kSize>());
  return mail;
}

/// The abort of a transfer is an SDO request in both directions (ETG.1000.6 5.6.2.7).
std::vector<std::byte> abort_message(const SdoRefusal& refusal) {
  SdoHeader sdo;
  sdo.command = command_byte(wire::SdoRequestCommand::kAbort);
  sdo.index = refusal.request.index;
  sdo.subindex = refusal.request.subindex;
  sdo.data = bytes::to_le_bytes(refusal.abort_code);
  return sdo_message(CoeService::kSdoRequest, sdo);
}

/// An SDO upload of 1000h, which the device asks for.
std::vector<std::byte> upload_of_device_type(std::uint16_t address) {
  SdoHeader sdo;
  sdo.command = command_byte(wire::SdoRequestCommand::kInitiateUpload);
  sdo.index = 0x1000;
  return sdo_message(CoeService::kSdoRequest, sdo, address);
}

/// The value of 1000h for a servo drive, as an answer to no request since power-on.
std::vector<std::byte> stale_answer() {
  SdoHeader sdo;
  sdo.command = wire::expedited_command(static_cast<std::uint8_t>(wire::SdoResponseCommand::kInitiateUpload), 4);
  sdo.index = 0x1000;
  sdo.data = bytes::to_le_bytes(std::uint32_t{0x00020192});
  return sdo_message(CoeService::kSdoResponse, sdo);
}

/// Returns the header of an expedited upload response; none: the message is another one.
std::optional<SdoHeader> expedited_upload(std::span<const std::byte> mail) noexcept {
  const auto header = MailboxHeader::decode(mail);
  if (!header || header->type != wire::MailboxType::kCoe || mail.size() <= kSdoAt) return std::nullopt;
  const auto coe = CoeHeader::decode(mail.subspan(kServiceAt));
  const auto sdo = SdoHeader::decode(mail.subspan(kSdoAt));
  if (!coe || coe->service != CoeService::kSdoResponse || !sdo || !sdo->expedited()) return std::nullopt;
  if (sdo->specifier() != static_cast<std::uint8_t>(wire::SdoResponseCommand::kInitiateUpload)) return std::nullopt;
  return *sdo;
}

std::vector<std::byte> emergency() {
  auto mail = coe_message(CoeService::kEmergency, 0);
  kUndervoltage.encode(std::span(mail).subspan<kSdoAt, wire::Emergency::kSize>());
  return mail;
}

}  // namespace

MailboxHabits::MailboxHabits(std::span<const Persona> personas)
    : personas_(personas.begin(), personas.end()), obstacles_(personas) {}

void MailboxHabits::start(Nanoseconds now) noexcept {
  own_.clear();
  unasked_due_ = true;
  start_ = answer_at_ = now;
  requests_ = 0;
  counter_ = request_counter_ = handled_counter_ = device_counter_ = 0;
  refused_last_ = false;
}

bool MailboxHabits::deaf(Nanoseconds now) const noexcept {
  const auto* persona = find_persona(personas_, Kind::kDeafAfterPreOp);
  return persona != nullptr && now - start_ < milliseconds{persona->value};
}

bool MailboxHabits::loses_next() noexcept {
  const auto* persona = find_persona(personas_, Kind::kLostRequests);
  return persona != nullptr && ++requests_ % persona->value == 0;
}

std::span<const std::byte> MailboxHabits::renumbered(std::span<const std::byte> mail, bool repeated) {
  for_device_.assign(mail.begin(), mail.end());
  if (request_counter_ == 0) return for_device_;
  if (!repeated) device_counter_ = wire::next_mailbox_counter(device_counter_);
  const auto type = std::to_integer<unsigned>(mail[kCounterByte]) & 0x8FU;
  for_device_[kCounterByte] = static_cast<std::byte>(type | unsigned{device_counter_} << 4U);
  return for_device_;
}

std::span<const std::byte> MailboxHabits::request(std::span<const std::byte> mail, Nanoseconds now) {
  request_counter_ = mail.size() > kCounterByte ? counter_of(mail) : std::uint8_t{0};
  if (deaf(now) || loses_next()) return {};
  const bool repeated = request_counter_ != 0 && request_counter_ == handled_counter_;
  handled_counter_ = request_counter_;
  if (repeated) return refused_last_ ? std::span<const std::byte>{} : renumbered(mail, true);
  answer_at_ = now + milliseconds{persona_value(personas_, Kind::kLateAnswers, 0)};
  const auto refusal = obstacles_.refuse(mail);
  refused_last_ = refusal.has_value();
  if (refusal) own_.push_back(abort_message(*refusal));
  if (has_persona(personas_, Kind::kRequestsToMaster)) own_.push_back(upload_of_device_type(0));
  if (const auto* persona = find_persona(personas_, Kind::kMessagesToSlave); persona != nullptr) {
    own_.push_back(upload_of_device_type(static_cast<std::uint16_t>(persona->value)));
  }
  return refusal ? std::span<const std::byte>{} : renumbered(mail, false);
}

void MailboxHabits::add_unasked() {
  if (!unasked_due_) return;
  unasked_due_ = false;
  if (has_persona(personas_, Kind::kStaleMessage)) own_.push_front(stale_answer());
  const auto count = persona_value(personas_, Kind::kEmergencies, 0);
  for (std::uint32_t i = 0; i < count; ++i) own_.push_front(emergency());
}

std::size_t MailboxHabits::own_message(std::span<std::byte> out) {
  add_unasked();
  if (own_.empty() || own_.front().size() > out.size()) return 0;
  const auto length = own_.front().size();
  std::copy(own_.front().begin(), own_.front().end(), out.begin());
  own_.pop_front();
  return length;
}

std::uint8_t MailboxHabits::next_counter() noexcept {
  counter_ = wire::next_mailbox_counter(counter_);
  if (const auto* persona = find_persona(personas_, Kind::kConstantCounter); persona != nullptr) {
    return static_cast<std::uint8_t>(persona->value);
  }
  if (has_persona(personas_, Kind::kRequestCounter)) return request_counter_;
  // 4, 7, 3, 6, 2, 5, 1: every value once, never the next one.
  if (has_persona(personas_, Kind::kJumpingCounter)) return static_cast<std::uint8_t>(counter_ * 3U % 7U + 1U);
  return counter_;
}

/// Expedited upload responses: `s` clear, or `n` = 0 (CiA 301 7.2.4.3.6).
void MailboxHabits::rewrite_size(std::span<std::byte> mail) const noexcept {
  const bool four = has_persona(personas_, Kind::kFourByteAnswers);
  const bool none = has_persona(personas_, Kind::kAnswersWithoutSize);
  if (!four && !none) return;
  const auto sdo = expedited_upload(mail);
  if (!sdo) return;
  const auto size = none ? std::uint8_t{0} : SdoHeader::kSizeIndicated;
  const unsigned rest = sdo->command & 0xF2U;  // without n and s
  mail[kSdoAt] = static_cast<std::byte>(rest | size);
}

/// The answer to an upload of 1C12h:00 or 1C13h:00.
void MailboxHabits::rewrite_assignment(std::span<std::byte> mail) const noexcept {
  const auto* persona = find_persona(personas_, Kind::kOverstatedAssignment);
  if (persona == nullptr) return;
  const auto sdo = expedited_upload(mail);
  if (!sdo || (sdo->index != 0x1C12 && sdo->index != 0x1C13) || sdo->subindex != 0) return;
  const auto counted = std::to_integer<std::uint32_t>(mail[kSdoDataAt]) + persona->value;
  mail[kSdoDataAt] = static_cast<std::byte>(std::min(counted, std::uint32_t{255}));
}

void MailboxHabits::rewrite(std::span<std::byte> mail) noexcept {
  if (mail.size() <= kCounterByte) return;
  rewrite_assignment(mail);
  rewrite_size(mail);
  const auto type = std::to_integer<unsigned>(mail[kCounterByte]) & 0x0FU;
  mail[kCounterByte] = static_cast<std::byte>(type | unsigned{next_counter()} << 4U);
}

}  // namespace driveline::slaves
