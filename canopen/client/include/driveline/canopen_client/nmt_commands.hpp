#pragma once

#include "driveline/canopen_client/bus_link.hpp"
#include "driveline/canopen_wire/nmt.hpp"

namespace driveline::canopen {

/// Sends the commands of an NMT master (CiA 301 7.2.8.2.1). Nodes do not confirm them.
class NmtCommands {
 public:
  /// All nodes instead of one.
  static constexpr std::uint8_t kAll = 0;

  /// The link must outlive this.
  explicit NmtCommands(BusLink& link) noexcept : link_(&link) {}

  /// Sends a command to a node, 1 to 127, or to kAll. Errors: those of BusLink::send().
  [[nodiscard]] ClientResult<void> send(NmtCommand command, std::uint8_t node);
  /// Operational.
  [[nodiscard]] ClientResult<void> start(std::uint8_t node) { return send(NmtCommand::kStart, node); }
  /// Stopped.
  [[nodiscard]] ClientResult<void> stop(std::uint8_t node) { return send(NmtCommand::kStop, node); }
  /// Pre-operational.
  [[nodiscard]] ClientResult<void> enter_pre_operational(std::uint8_t node) {
    return send(NmtCommand::kEnterPreOperational, node);
  }
  /// Starts the node anew, with the application.
  [[nodiscard]] ClientResult<void> reset_node(std::uint8_t node) { return send(NmtCommand::kResetNode, node); }
  /// Starts the communication of the node anew.
  [[nodiscard]] ClientResult<void> reset_communication(std::uint8_t node) {
    return send(NmtCommand::kResetCommunication, node);
  }

  /// Asks a node for its state by a remote frame, as node guarding does (CiA 301 7.2.8.2.2.1), and waits up to
  /// `timeout`. The toggle bit of the node changes, which a master that guards the node takes for an error. Errors:
  /// those of BusLink::send(); kNotCarried: the adapter has no remote frames; kNoAnswer.
  [[nodiscard]] ClientResult<ErrorControl> guard(std::uint8_t node, std::chrono::nanoseconds timeout);

 private:
  BusLink* link_;
};

}  // namespace driveline::canopen
