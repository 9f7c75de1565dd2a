#pragma once

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::canopen {

/// What a node tells of itself without being asked.
struct NodeCondition {
  std::optional<NmtState> state;       ///< of the last boot-up message, heartbeat or guarding answer
  std::chrono::nanoseconds heard{0};   ///< when that was
  std::chrono::nanoseconds period{0};  ///< between the last two of them; 0: there was one
  std::uint64_t boot_ups = 0;          ///< boot-up messages
  std::uint64_t heartbeats = 0;        ///< heartbeats and guarding answers
  std::optional<Emergency> emergency;  ///< last EMCY message
  std::uint64_t emergencies = 0;       ///< EMCY messages
};

/// Follows the states and emergencies of all nodes by the frames that pass, on the predefined identifiers.
class NodeStates {
 public:
  /// Looks at a frame. \rtsafe
  void receive(const ReceivedFrame& received) noexcept;
  /// What is known of a node, 1 to 127. \rtsafe
  [[nodiscard]] const NodeCondition& of(std::uint8_t node) const noexcept { return nodes_[node & kMaxNodeId]; }
  /// Forgets the state of a node, so that the next message tells it. \rtsafe
  void forget(std::uint8_t node) noexcept { nodes_[node & kMaxNodeId].state.reset(); }

 private:
  std::array<NodeCondition, kMaxNodeId + 1U> nodes_{};
};

}  // namespace driveline::canopen
