#include "driveline/ecat_master/soe/soe_transfer.hpp"

#include <algorithm>
#include <utility>

namespace driveline::ecat_master {
namespace {

using wire::SoeHeader;
using wire::SoeOpCode;

std::vector<std::byte> make_service(const SoeHeader& header, std::span<const std::byte> data) {
  std::vector<std::byte> service(SoeHeader::kSize + data.size());
  header.encode(std::span(service).first<SoeHeader::kSize>());
  std::copy(data.begin(), data.end(), service.begin() + SoeHeader::kSize);
  return service;
}

}  // namespace

SoeTransfer::SoeTransfer(facts::SoeDatum at, wire::SoeElementSet elements)
    : MailboxDialogue(wire::MailboxType::kSoe, 0), at_(at), elements_(elements), write_(false) {}

SoeTransfer::SoeTransfer(facts::SoeDatum at, wire::SoeElement element, std::vector<std::byte> data,
                         std::uint8_t priority)
    : MailboxDialogue(wire::MailboxType::kSoe, priority),
      at_(at),
      elements_(element),
      write_(true),
      data_(std::move(data)) {}

SoeHeader SoeTransfer::header() const noexcept {
  return {write_ ? SoeOpCode::kWriteRequest : SoeOpCode::kReadRequest, false, false, at_.drive, elements_, at_.idn.raw};
}

std::vector<std::vector<std::byte>> SoeTransfer::split(std::uint16_t position, std::size_t room) {
  position_ = position;
  std::vector<std::vector<std::byte>> services;
  if (!write_ || room <= SoeHeader::kSize || data_.empty()) return services;
  const auto most = room - SoeHeader::kSize;
  auto left = (data_.size() - 1) / most;
  if (left > 0xFFFF) return services;
  confirmations_ = left;
  for (; left > 0; --left, ahead_ += most) {
    auto part = header();
    part.incomplete = true;
    part.value = static_cast<std::uint16_t>(left);
    services.push_back(make_service(part, std::span(data_).subspan(ahead_, most)));
  }
  return services;
}

void SoeTransfer::abandon(const Error& error) {
  if (result_) result_ = tl::unexpected(error);
}

void SoeTransfer::begin(std::uint16_t position, MailboxRoom room) {
  position_ = position;
  outgoing_ = make_service(header(), std::span(data_).subspan(ahead_));
  // Make it too large for the mailbox, so that it is refused and not sent.
  if (failed()) outgoing_.resize(room.out + 1);
  if (!write_) data_.clear();
}

MailboxDialogue::Reaction SoeTransfer::end(const ErrorFacts& facts) {
  result_ = tl::unexpected(Error{facts, position_});
  return Reaction::kDone;
}

MailboxDialogue::Reaction SoeTransfer::receive(std::span<const std::byte> service) {
  const auto header = SoeHeader::decode(service);
  const bool awaited = header && header->op_code == (write_ ? SoeOpCode::kWriteResponse : SoeOpCode::kReadResponse);
  if (!awaited) {
    unusable_ = unusable_ || !header;
    return Reaction::kForeign;
  }
  const auto data = service.subspan(SoeHeader::kSize);
  // The number of fragments is in the place of the IDN.
  const facts::SoeDatum about{header->drive, header->incomplete ? at_.idn : header->idn()};
  if (about != at_) return end(facts::SoeOther{at_, about});
  if (header->error) {
    if (data.size() < sizeof(wire::SoeError)) return end(facts::MailboxMalformed{});
    const auto code = bytes::load_le<std::uint16_t>(data.last(sizeof(wire::SoeError)));
    return end(facts::SoeRefused{at_, static_cast<wire::SoeError>(code)});
  }
  return header->incomplete ? receive_part(*header, data) : receive_last(*header, data);
}

bool SoeTransfer::append(std::span<const std::byte> data) {
  if (data.size() > kLargest - data_.size()) return false;
  data_.insert(data_.end(), data.begin(), data.end());
  return true;
}

MailboxDialogue::Reaction SoeTransfer::receive_part(const SoeHeader& header, std::span<const std::byte> data) {
  if (write_) return receive_confirmation(header);
  const bool counts = !left_ || (*left_ > 0 && header.value + 1 == *left_);
  if (!counts || header.value == 0) {
    const auto expected = left_.value_or(1);
    return end(facts::SoeFragments{at_, static_cast<std::uint16_t>(left_ ? expected - 1 : expected), header.value});
  }
  left_ = header.value;
  // A fragment without data would let a slave prolong the transfer at no cost.
  if (data.empty() || !append(data)) return end(facts::MailboxMalformed{});
  return Reaction::kAwait;
}

/// Some slaves confirm each fragment. Each confirmation extends the time-out, so no more than the fragments sent are
/// accepted; otherwise the transfer would never end.
MailboxDialogue::Reaction SoeTransfer::receive_confirmation(const SoeHeader& header) {
  if (confirmations_ == 0) return end(facts::SoeFragments{at_, 0, header.value});
  --confirmations_;
  return Reaction::kAwait;
}

MailboxDialogue::Reaction SoeTransfer::receive_last(const SoeHeader& header, std::span<const std::byte> data) {
  if (write_) {
    result_ = SoeReading{};
    return Reaction::kDone;
  }
  // Some slaves include the current fragment in the number.
  if (left_.value_or(1) > 2) return end(facts::SoeFragments{at_, static_cast<std::uint16_t>(*left_ - 1), 0});
  if ((header.elements.bits & ~elements_.bits) != 0 || !append(data)) return end(facts::MailboxMalformed{});
  result_ = SoeReading{header.elements, std::move(data_)};
  return Reaction::kDone;
}

void SoeTransfer::fail(const Error& failure) {
  if (failed()) return;
  auto error = failure;
  if (unusable_ && error.is<facts::MailboxTimeout>()) error.facts = facts::MailboxMalformed{};
  result_ = tl::unexpected(error);
}

}  // namespace driveline::ecat_master
