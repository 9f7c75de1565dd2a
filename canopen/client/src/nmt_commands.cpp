#include "driveline/canopen_client/nmt_commands.hpp"

namespace driveline::canopen {
namespace {

constexpr std::chrono::nanoseconds kNmtPatience = std::chrono::milliseconds{500};  ///< with a full queue of the adapter

}  // namespace

ClientResult<void> NmtCommands::send(NmtCommand command, std::uint8_t node) {
  return link_->send(NmtRequest{command, node}.frame(), kNmtPatience);
}

ClientResult<ErrorControl> NmtCommands::guard(std::uint8_t node, std::chrono::nanoseconds timeout) {
  const Identifier identifier{predefined::kErrorControl + node};
  ClientError error{ClientErrorKind::kNoAnswer, node};
  error.waited = timeout;
  const auto begin = link_->now();
  if (const auto sent = link_->send(Frame::remote(identifier, ErrorControl::kSize), kNmtPatience); !sent) {
    error.kind = sent.error().kind;
    return tl::unexpected(error);
  }
  while (link_->now() < begin + timeout) {
    const auto received = link_->receive(begin + timeout);
    if (!received) break;
    if (received->frame.kind != FrameKind::kData || received->frame.identifier != identifier) continue;
    if (const auto state = ErrorControl::decode(received->frame.payload())) return *state;
  }
  if (link_->stopped()) error.kind = ClientErrorKind::kStopped;
  if (link_->down()) error.kind = ClientErrorKind::kDown;
  return tl::unexpected(error);
}

}  // namespace driveline::canopen
