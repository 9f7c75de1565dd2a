#include "driveline/slaves/mailbox/mailbox_server.hpp"

#include <algorithm>

namespace driveline::slaves {

using wire::MailboxErrorCode;
using wire::MailboxHeader;
using wire::MailboxType;

namespace {

/// Returns the counter, 1 to 7; 0: not used.
std::uint8_t counter_of(std::span<const std::byte> mailbox) noexcept {
  if (mailbox.size() < MailboxHeader::kSize) return 0;
  return (bytes::load_le<std::uint8_t>(mailbox.subspan(5)) >> 4) & 7U;
}

}  // namespace

MailboxServer::MailboxServer(std::span<MailboxProtocol* const> protocols, std::size_t max_size)
    : protocols_(protocols.begin(), protocols.end()) {
  for (auto& slot : queue_) slot.data.resize(max_size);
}

void MailboxServer::reset() noexcept {
  head_ = 0;
  count_ = 0;
  last_counter_ = 0;
  counter_ = 0;
  endless_next_ = false;
  for (auto* protocol : protocols_) protocol->stop();
}

/// A master that gets no working counter for its write sends the same mailbox message again, with the same counter.
bool MailboxServer::repeats(std::span<const std::byte> mailbox) const noexcept {
  const auto counter = counter_of(mailbox);
  return counter != 0 && counter == last_counter_;
}

/// Returns the protocol that handles the mailbox message without an answer; null: none.
MailboxProtocol* MailboxServer::unanswering(std::span<const std::byte> mailbox) const noexcept {
  const auto header = MailboxHeader::decode(mailbox);
  if (!header) return nullptr;
  auto* handler = protocol(header->type);
  const auto data = mailbox.subspan(MailboxHeader::kSize, header->length);
  return handler != nullptr && handler->without_answer(data) ? handler : nullptr;
}

bool MailboxServer::has_room(std::span<const std::byte> mailbox) const noexcept {
  return count_ < kQueueDepth || repeats(mailbox) || unanswering(mailbox) != nullptr;
}

void MailboxServer::request(std::span<const std::byte> mailbox) {
  if (repeats(mailbox)) {
    ++repeated_;
    return;
  }
  if (const auto counter = counter_of(mailbox); counter != 0) last_counter_ = counter;
  if (auto* handler = unanswering(mailbox); handler != nullptr) {
    const auto data = mailbox.subspan(MailboxHeader::kSize);
    const auto length = MailboxHeader::decode(mailbox)->length;
    static_cast<void>(handler->request({data.first(length), data.size(), wire::AlState::kNone}, {}));
    return;
  }
  if (count_ == kQueueDepth) {
    ++dropped_;
    return;
  }
  Request& slot = queue_[(head_ + count_++) % kQueueDepth];
  slot.error.reset();
  slot.header = {};
  slot.length = 0;
  const auto header = MailboxHeader::decode(mailbox);
  if (!header) {
    slot.error = header.error() == wire::DecodeError::kTooShort ? MailboxErrorCode::kSizeTooShort
                                                                : MailboxErrorCode::kInvalidSize;
    return;
  }
  slot.header = *header;
  slot.room = static_cast<std::uint16_t>(mailbox.size() - MailboxHeader::kSize);
  if (header->length > slot.data.size()) {
    slot.error = MailboxErrorCode::kInvalidSize;
    return;
  }
  slot.length = header->length;
  std::copy_n(mailbox.begin() + MailboxHeader::kSize, slot.length, slot.data.begin());
}

MailboxProtocol* MailboxServer::protocol(MailboxType type) const noexcept {
  const auto found =
      std::find_if(protocols_.begin(), protocols_.end(), [type](const auto* p) { return p->type() == type; });
  return found == protocols_.end() ? nullptr : *found;
}

std::size_t MailboxServer::send(MailboxType type, std::size_t length, std::uint16_t address, std::span<std::byte> out) {
  counter_ = wire::next_mailbox_counter(counter_);
  MailboxHeader header;
  header.length = static_cast<std::uint16_t>(length);
  header.address = address;
  header.type = type;
  header.counter = counter_;
  header.encode(out.first<MailboxHeader::kSize>());
  return MailboxHeader::kSize + length;
}

std::size_t MailboxServer::send_error(MailboxErrorCode code, std::uint16_t address, std::span<std::byte> out) {
  if (out.size() < MailboxHeader::kSize + wire::MailboxErrorReply::kSize) return 0;
  wire::MailboxErrorReply{code}.encode(out.subspan<MailboxHeader::kSize, wire::MailboxErrorReply::kSize>());
  return send(MailboxType::kError, wire::MailboxErrorReply::kSize, address, out);
}

std::size_t MailboxServer::answer(const Request& request, wire::AlState state, std::span<std::byte> out) {
  const auto address = request.header.address;
  if (request.error) return send_error(*request.error, address, out);
  // The master could not process a message; a mailbox error as answer would only repeat that.
  if (request.header.type == MailboxType::kError) return 0;
  auto* handler = protocol(request.header.type);
  const bool served = state != wire::AlState::kBootstrap || request.header.type == MailboxType::kFoe;
  if (handler == nullptr || !served) return send_error(MailboxErrorCode::kUnsupportedProtocol, address, out);
  const MailboxRequest asked{std::span(request.data).first(request.length), request.room, state};
  const auto length = handler->request(asked, out.subspan(MailboxHeader::kSize));
  if (!length) return send_error(length.error(), address, out);
  return *length == 0 ? 0 : send(handler->type(), *length, address, out);
}

/// Sends an unsolicited message, of the endless() protocols or of the other ones.
std::size_t MailboxServer::say_unasked(bool endless, std::span<std::byte> out) {
  for (auto* handler : protocols_) {
    if (handler->endless() != endless) continue;
    const auto length = handler->unsolicited(out.subspan(MailboxHeader::kSize));
    if (length == 0) continue;
    endless_next_ = !endless;
    return send(handler->type(), length, 0, out);
  }
  return 0;
}

std::size_t MailboxServer::answer_next(wire::AlState state, std::span<std::byte> out) {
  while (count_ != 0) {
    const std::size_t length = answer(queue_[head_], state, out);
    head_ = (head_ + 1) % kQueueDepth;
    --count_;
    if (length == 0) continue;
    endless_next_ = true;
    return length;
  }
  return 0;
}

std::size_t MailboxServer::reply(std::span<std::byte> out, wire::AlState state) {
  if (out.size() <= MailboxHeader::kSize) return 0;
  const auto first = endless_next_ ? say_unasked(true, out) : 0;
  if (first != 0) return first;
  if (const auto length = say_unasked(false, out); length != 0) return length;
  if (const auto length = answer_next(state, out); length != 0) return length;
  return endless_next_ ? 0 : say_unasked(true, out);
}

}  // namespace driveline::slaves
