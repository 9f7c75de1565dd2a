#include "driveline/slaves/canopen/heartbeat_consumer.hpp"

#include <algorithm>

namespace driveline::slaves::cia301 {

HeartbeatConsumer::HeartbeatConsumer(ObjectDictionary& dictionary) {
  for (const EntryRow& row : dictionary.table().object(0x1016)) {
    if (row.subindex != 0) monitors_.push_back({Entry(dictionary, 0x1016, row.subindex)});
  }
}

void HeartbeatConsumer::restart() noexcept {
  for (Monitor& monitor : monitors_) {
    monitor.state = State::kUnknown;
    monitor.deadline = kNever;
  }
}

SdoResult<void> HeartbeatConsumer::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  const auto node = static_cast<std::uint8_t>(raw >> 16);
  const bool used = node != 0 && (raw & 0xFFFFU) != 0;
  const bool is_here =
      std::any_of(monitors_.begin(), monitors_.end(), [&](const auto& one) { return one.entry.is(row); });
  if (!used || !is_here) return {};
  const bool twice = std::any_of(monitors_.begin(), monitors_.end(), [&](const Monitor& one) {
    return !one.entry.is(row) && one.node() == node && one.time().count() != 0;
  });
  if (twice) return tl::unexpected(sdo::SdoAbort::kParameterIncompatible);
  return {};
}

void HeartbeatConsumer::written(const EntryRow& row) noexcept {
  for (Monitor& monitor : monitors_) {
    if (!monitor.entry.is(row)) continue;
    monitor.state = State::kUnknown;
    monitor.deadline = kNever;
  }
}

HeartbeatConsumer::Event HeartbeatConsumer::receive(std::uint8_t node, canopen::NmtState state,
                                                    nanoseconds now) noexcept {
  for (Monitor& monitor : monitors_) {
    if (node == 0 || monitor.node() != node || monitor.time().count() == 0) continue;
    const State before = std::exchange(monitor.state, State::kAlive);
    monitor.deadline = now + monitor.time();
    if (before == State::kLost) return Event::kBack;
    return state == canopen::NmtState::kInitialising && before == State::kAlive ? Event::kBootUp : Event::kNone;
  }
  return Event::kNone;
}

HeartbeatConsumer::Event HeartbeatConsumer::advance(nanoseconds now) noexcept {
  for (Monitor& monitor : monitors_) {
    if (monitor.deadline > now) continue;
    monitor.state = State::kLost;
    monitor.deadline = kNever;
    return Event::kLost;
  }
  return Event::kNone;
}

nanoseconds HeartbeatConsumer::next_wake() const noexcept {
  nanoseconds next = kNever;
  for (const Monitor& monitor : monitors_) next = std::min(next, monitor.deadline);
  return next;
}

bool HeartbeatConsumer::any_lost() const noexcept {
  return std::any_of(monitors_.begin(), monitors_.end(), [](const Monitor& one) { return one.state == State::kLost; });
}

}  // namespace driveline::slaves::cia301
