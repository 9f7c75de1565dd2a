#include "driveline/canopen_client/sdo_client.hpp"

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

/// Where requests or answers of a node are.
Identifier channel_of(Identifier base, std::uint8_t node) {
  return {base.value + node, base.extended};
}

}  // namespace

SdoClient::SdoClient(BusLink& link, std::uint8_t node, const SdoOptions& options)
    : link_(&link), node_(node), options_(options) {}

ClientResult<std::vector<std::byte>> SdoClient::upload(SdoObject object) {
  return run(*SdoTransfer::upload(node_, object, options_));
}

ClientResult<std::uint32_t> SdoClient::upload_number(SdoObject object) {
  const auto data = upload(object);
  if (!data) return tl::unexpected(data.error());
  if (data->size() > sizeof(std::uint32_t)) {
    ClientError error{ClientErrorKind::kBadAnswer, node_, object, SdoAbort::kLengthTooHigh};
    error.expected = sizeof(std::uint32_t);
    error.received = static_cast<std::uint32_t>(data->size());
    return tl::unexpected(error);
  }
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < data->size(); ++i) value |= std::to_integer<std::uint32_t>((*data)[i]) << 8U * i;
  return value;
}

ClientResult<void> SdoClient::download(SdoObject object, std::span<const std::byte> data) {
  const auto done = run(*SdoTransfer::download(node_, object, data, options_));
  if (!done) return tl::unexpected(done.error());
  return {};
}

ClientResult<void> SdoClient::download_number(SdoObject object, std::uint32_t value, std::size_t bytes) {
  const auto data = bytes::to_le_bytes(value);
  return download(object, std::span(data).first(bytes));
}

bool SdoClient::is_answer(const Frame& frame) const noexcept {
  return frame.kind == FrameKind::kData && frame.identifier == channel_of(options_.answer, node_);
}

ClientResult<std::vector<std::byte>> SdoClient::run(SdoTransfer& transfer) {
  pass_over_old_answers();
  while (!transfer.done()) {
    if (transfer.outgoing()) {
      send(transfer);
      // An abort of the node ends the sub-block that is being sent.
      receive(transfer, link_->now());
      continue;
    }
    receive(transfer, transfer.deadline());
    if (link_->down()) {
      transfer.fail({ClientErrorKind::kDown});
    } else if (link_->stopped()) {
      transfer.give_up(ClientErrorKind::kStopped);
    } else {
      transfer.advance(link_->now());
    }
  }
  if (transfer.abandoned()) old_answer_until_ = link_->now() + options_.answer_timeout;
  return std::move(transfer.result());
}

void SdoClient::pass_over_old_answers() {
  // What has arrived before the request is no answer to it.
  const nanoseconds begin = link_->now();
  while (const auto frame = link_->receive(begin)) {
    if (frame->time >= begin) break;
    if (is_answer(frame->frame)) old_answer_until_ = nanoseconds{0};
  }
  // An answer to the same object would be taken for that of the new request: it has its time to come.
  while (link_->now() < old_answer_until_ && !link_->stopped()) {
    const auto frame = link_->receive(old_answer_until_);
    if (!frame || is_answer(frame->frame)) break;
  }
  old_answer_until_ = nanoseconds{0};
}

void SdoClient::send(SdoTransfer& transfer) {
  const auto frame = Frame::of(channel_of(options_.request, node_), *transfer.outgoing());
  if (const auto sent = link_->send(frame, options_.answer_timeout); !sent) return transfer.fail(sent.error());
  transfer.sent(link_->now());
}

void SdoClient::receive(SdoTransfer& transfer, nanoseconds deadline) {
  const auto frame = link_->receive(deadline);
  if (frame && is_answer(frame->frame)) transfer.receive(frame->frame.payload());
}

}  // namespace driveline::canopen
