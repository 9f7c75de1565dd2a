#include "driveline/slaves/canopen/nmt_machine.hpp"

#include <utility>

namespace driveline::slaves::cia301 {

using canopen::NmtCommand;

bool NmtQueue::add(const canopen::Frame& frame) noexcept {
  if (count_ == kCapacity) return false;
  frames_[(first_ + count_++) % kCapacity] = frame;
  return true;
}

std::optional<canopen::Frame> NmtQueue::take() noexcept {
  if (count_ == 0) return std::nullopt;
  --count_;
  return frames_[std::exchange(first_, (first_ + 1) % kCapacity)];
}

bool NmtMachine::enter(NmtState state) noexcept {
  const bool changes = state != state_;
  state_ = state;
  return changes;
}

NmtMachine::Action NmtMachine::entered(NmtState state) noexcept {
  return enter(state) ? Action::kStateChanged : Action::kNone;
}

NmtMachine::Action NmtMachine::request(std::span<const std::byte> payload, std::uint8_t node_id,
                                       bool may_start) noexcept {
  const auto request = canopen::NmtRequest::decode(payload);
  const bool mine = request && (request->node == 0 || request->node == node_id);
  if (mine && state_ != NmtState::kInitialising) {
    switch (request->command) {
      case NmtCommand::kStart:
        if (!may_start) break;
        return entered(NmtState::kOperational);
      case NmtCommand::kStop:
        return entered(NmtState::kStopped);
      case NmtCommand::kEnterPreOperational:
        return entered(NmtState::kPreOperational);
      case NmtCommand::kResetNode:
        return Action::kResetNode;
      case NmtCommand::kResetCommunication:
        return Action::kResetCommunication;
    }
  }
  ++ignored_;
  return Action::kNone;
}

}  // namespace driveline::slaves::cia301
