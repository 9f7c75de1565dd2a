#include "driveline/ecat_master/mailbox/mail_exchange.hpp"

#include "driveline/wire/coe.hpp"

namespace driveline::ecat_master {
namespace {

/// Whether more of a list follows. SDO information: bit 7 of the op-code byte (ETG.1000.6 Table 43).
bool more_of_a_list(std::span<const std::byte> service) {
  constexpr std::size_t kOpCode = wire::CoeHeader::kSize;
  const auto header = wire::CoeHeader::decode(service);
  return header && header->service == wire::CoeService::kSdoInformation && service.size() > kOpCode &&
         (service[kOpCode] & std::byte{0x80}) != std::byte{0};
}

/// Whether more fragments follow. SoE: bit 3, "incomplete" (ETG.1000.6 Table 95).
bool more_fragments(std::span<const std::byte> service) {
  return !service.empty() && (service[0] & std::byte{0x08}) != std::byte{0};
}

bool is_emergency(std::span<const std::byte> service) {
  const auto header = wire::CoeHeader::decode(service);
  return header && header->service == wire::CoeService::kEmergency;
}

}  // namespace

MailExchange::MailExchange(wire::MailboxType type, std::vector<std::byte> service,
                           std::optional<std::chrono::nanoseconds> timeout)
    : MailboxDialogue(type, 0), service_(std::move(service)), timeout_(timeout) {}

void MailExchange::begin(std::uint16_t position, MailboxRoom room) {
  position_ = position;
  answer_room_ = room.in;
  answers_.emplace();
}

MailboxDialogue::Reaction MailExchange::receive(std::span<const std::byte> service) {
  const bool coe = type() == wire::MailboxType::kCoe;
  // The slave may ask the master for something meanwhile.
  if (coe && (is_emergency(service) || wire::is_coe_request(service))) return Reaction::kForeign;
  kept_bytes_ += service.size() + kBytesPerMessage;
  if (kept_bytes_ > kLargest) {
    answers_ = tl::unexpected(Error{facts::MailboxMalformed{}, position_});
    return Reaction::kDone;
  }
  answers_->emplace_back(service.begin(), service.end());
  const bool more = coe ? more_of_a_list(service) : type() == wire::MailboxType::kSoe && more_fragments(service);
  return more ? Reaction::kAwait : Reaction::kDone;
}

}  // namespace driveline::ecat_master
