#include "driveline/canopen_client/node_states.hpp"

namespace driveline::canopen {
namespace {

/// The node of an identifier that begins at `base`; 0: it belongs to no node.
std::uint8_t node_of(const Identifier& identifier, std::uint32_t base) noexcept {
  const bool within = !identifier.extended && identifier.value > base && identifier.value <= base + kMaxNodeId;
  return within ? static_cast<std::uint8_t>(identifier.value - base) : std::uint8_t{0};
}

}  // namespace

void NodeStates::receive(const ReceivedFrame& received) noexcept {
  const Frame& frame = received.frame;
  if (frame.kind != FrameKind::kData) return;
  if (const auto node = node_of(frame.identifier, predefined::kErrorControl); node != 0) {
    const auto message = ErrorControl::decode(frame.payload());
    if (!message) return;
    NodeCondition& condition = nodes_[node];
    const bool boot_up = message->state == NmtState::kInitialising;
    if (condition.state) condition.period = received.time - condition.heard;
    // A node that has booted is in Pre-operational (CiA 301 7.3.2.1).
    condition.state = boot_up ? NmtState::kPreOperational : message->state;
    condition.heard = received.time;
    ++(boot_up ? condition.boot_ups : condition.heartbeats);
    return;
  }
  if (const auto node = node_of(frame.identifier, predefined::kEmergency); node != 0) {
    const auto message = Emergency::decode(frame.payload());
    if (!message) return;
    nodes_[node].emergency = message;
    ++nodes_[node].emergencies;
  }
}

}  // namespace driveline::canopen
