#include "driveline/slaves/mailbox/mailbox_server.hpp"

#include <algorithm>

namespace driveline::slaves {

using wire::MailboxErrorCode;
using wire::MailboxHeader;
using wire::MailboxType;

MailboxServer::MailboxServer(std::span<MailboxProtocol* const> protocols, std::size_t max_size)
    : protocols_(protocols.begin(), protocols.end()) {
  for (auto& slot : queue_) slot.data.resize(max_size);
}

void MailboxServer::reset() noexcept {
  head_ = 0;
  count_ = 0;
  last_counter_ = 0;
  counter_ = 0;
  for (auto* protocol : protocols_) protocol->stop();
}

/// A master that got no working counter for its write sends the same mailbox again; the counter tells (0: not used).
bool MailboxServer::is_repetition(std::uint8_t counter) noexcept {
  if (counter == 0) return false;
  const bool same = counter == last_counter_;
  last_counter_ = counter;
  if (same) ++repeated_;
  return same;
}

void MailboxServer::request(std::span<const std::byte> mailbox) {
  if (mailbox.size() >= MailboxHeader::kSize) {
    const auto type_counter = wire::load_le<std::uint8_t>(mailbox.subspan(5));
    if (is_repetition((type_counter >> 4) & 7U)) return;
  }
  if (count_ == kQueueDepth) {
    ++dropped_;
    return;
  }
  Request& slot = queue_[(head_ + count_++) % kQueueDepth];
  slot.error.reset();
  slot.length = 0;
  const auto header = MailboxHeader::decode(mailbox);
  if (!header) {
    slot.error = header.error() == wire::DecodeError::kTooShort ? MailboxErrorCode::kSizeTooShort
                                                                : MailboxErrorCode::kInvalidSize;
    return;
  }
  slot.header = *header;
  slot.room = mailbox.size() - MailboxHeader::kSize;
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

std::size_t MailboxServer::send(MailboxType type, std::size_t length, std::span<std::byte> out) {
  counter_ = wire::next_mailbox_counter(counter_);
  MailboxHeader header;
  header.length = static_cast<std::uint16_t>(length);
  header.type = type;
  header.counter = counter_;
  header.encode(out.first<MailboxHeader::kSize>());
  return MailboxHeader::kSize + length;
}

std::size_t MailboxServer::send_error(MailboxErrorCode code, std::span<std::byte> out) {
  if (out.size() < MailboxHeader::kSize + wire::MailboxErrorReply::kSize) return 0;
  wire::MailboxErrorReply{code}.encode(out.subspan<MailboxHeader::kSize, wire::MailboxErrorReply::kSize>());
  return send(MailboxType::kError, wire::MailboxErrorReply::kSize, out);
}

std::size_t MailboxServer::answer(const Request& request, wire::AlState state, std::span<std::byte> out) {
  if (request.error) return send_error(*request.error, out);
  // What the master could not understand; an answer to it would be the same again.
  if (request.header.type == MailboxType::kError) return 0;
  auto* handler = protocol(request.header.type);
  const bool served = state != wire::AlState::kBootstrap || request.header.type == MailboxType::kFoe;
  if (handler == nullptr || !served) return send_error(MailboxErrorCode::kUnsupportedProtocol, out);
  const MailboxRequest asked{std::span(request.data).first(request.length), request.room, state};
  const auto length = handler->request(asked, out.subspan(MailboxHeader::kSize));
  if (!length) return send_error(length.error(), out);
  return *length == 0 ? 0 : send(handler->type(), *length, out);
}

std::size_t MailboxServer::reply(std::span<std::byte> out, wire::AlState state) {
  if (out.size() <= MailboxHeader::kSize) return 0;
  for (auto* handler : protocols_) {
    const auto length = handler->unsolicited(out.subspan(MailboxHeader::kSize));
    if (length != 0) return send(handler->type(), length, out);
  }
  while (count_ != 0) {
    const std::size_t length = answer(queue_[head_], state, out);
    head_ = (head_ + 1) % kQueueDepth;
    --count_;
    if (length != 0) return length;
  }
  return 0;
}

}  // namespace driveline::slaves
