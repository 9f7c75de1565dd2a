#include "driveline/canopen_client/sdo_transfer.hpp"

#include <algorithm>

namespace driveline::canopen {
namespace {

using std::chrono::nanoseconds;

constexpr std::uint8_t kAbortCommand = sdo_command(SdoRequest::kAbort);  ///< the same of both sides

}  // namespace

void SdoTransfer::sent(nanoseconds now) {
  outgoing_.reset();
  if (finished_) return;
  deadline_ = now + options_.answer_timeout;
  continue_sending();
}

void SdoTransfer::receive(std::span<const std::byte> payload) {
  if (finished_) return;
  const auto message = SdoMessage::decode(payload);
  if (!message) return ignore();
  if (message->command == kAbortCommand) {
    // Within a transfer some servers leave the object of an abort empty. One about another object is of an old
    // transfer.
    const bool unnamed = message->index == 0 && message->subindex == 0 && !initiating_;
    if (!unnamed && !is_about_this(*message)) return ignore();
    auto error = error_of(ClientErrorKind::kAborted);
    error.code = static_cast<SdoAbort>(message->number());
    outgoing_.reset();
    return end(error);
  }
  SdoBytes in{};
  std::copy(payload.begin(), payload.end(), in.begin());
  answered(in);
}

void SdoTransfer::advance(nanoseconds now) {
  if (finished_ || outgoing_ || now < deadline_) return;
  if (repeated()) return;
  give_up(ClientErrorKind::kNoAnswer);
}

void SdoTransfer::give_up(ClientErrorKind kind) {
  if (finished_) return;
  abandoned_ = true;
  // The server would wait for ever otherwise: it has no time-out.
  const auto code = kind == ClientErrorKind::kNoAnswer ? SdoAbort::kTimeout : SdoAbort::kGeneralError;
  queue(abort_message(object_.index, object_.subindex, code).encode());
  auto error = error_of(kind);
  error.code = code;
  error.waited = options_.answer_timeout;
  end(error);
}

void SdoTransfer::fail(const ClientError& error) {
  outgoing_.reset();
  if (finished_) return;
  auto known = error;
  known.node = node_;
  known.object = object_;
  end(known);
}

void SdoTransfer::finish(std::vector<std::byte> data) {
  result_ = std::move(data);
  finished_ = true;
  deadline_ = nanoseconds::max();
}

void SdoTransfer::refuse(SdoAbort code, std::size_t expected, std::size_t received) {
  queue(abort_message(object_.index, object_.subindex, code).encode());
  reject(code, expected, received);
}

void SdoTransfer::reject(SdoAbort code, std::size_t expected, std::size_t received) {
  auto error = error_of(ClientErrorKind::kBadAnswer);
  error.code = code;
  error.expected = static_cast<std::uint32_t>(expected);
  error.received = static_cast<std::uint32_t>(received);
  end(error);
}

ClientError SdoTransfer::error_of(ClientErrorKind kind) const {
  ClientError error{kind, node_, object_};
  error.ignored = ignored_;
  return error;
}

void SdoTransfer::end(const ClientError& error) {
  result_ = tl::unexpected(error);
  finished_ = true;
  deadline_ = nanoseconds::max();
}

}  // namespace driveline::canopen
