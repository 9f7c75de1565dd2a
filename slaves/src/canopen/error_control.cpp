#include "driveline/slaves/canopen/error_control.hpp"

namespace driveline::slaves::cia301 {

ErrorControlService::ErrorControlService(ObjectDictionary& dictionary, Outbox& outbox) noexcept
    : outbox_(&outbox),
      producer_time_(dictionary, 0x1017, 0),
      guard_time_(dictionary, 0x100C, 0),
      life_time_factor_(dictionary, 0x100D, 0) {}

void ErrorControlService::send(canopen::NmtState state, bool toggle) noexcept {
  outbox_->send(Frame::of(identifier_, std::array{canopen::ErrorControl{state, toggle}.encode()}));
}

void ErrorControlService::restart(canopen::Identifier identifier, nanoseconds now) noexcept {
  identifier_ = identifier;
  toggle_ = false;
  life_lost_ = false;
  life_end_ = kNever;
  heartbeat_ = period().count() == 0 ? kNever : now + period();
}

void ErrorControlService::written(const EntryRow& row, canopen::NmtState state, nanoseconds now) noexcept {
  if (!producer_time_.is(row)) return;
  heartbeat_ = kNever;
  if (period().count() == 0) return;
  life_end_ = kNever;  // CiA 301 7.2.8.2.2.1: not both at the same time
  send(state, false);
  heartbeat_ = now + period();
}

ErrorControlService::Event ErrorControlService::remote(canopen::NmtState state, nanoseconds now) noexcept {
  if (period().count() != 0) return Event::kNone;
  send(state, toggle_);
  toggle_ = !toggle_;
  const nanoseconds life_time = std::chrono::milliseconds{guard_time_.value()} * life_time_factor_.value();
  life_end_ = life_time.count() == 0 ? kNever : now + life_time;
  return std::exchange(life_lost_, false) ? Event::kBack : Event::kNone;
}

ErrorControlService::Event ErrorControlService::advance(canopen::NmtState state, nanoseconds now) noexcept {
  if (heartbeat_ <= now) {
    send(state, false);
    // A device that is late leaves periods out, it does not send them in a burst.
    heartbeat_ += period() * (1 + (now - heartbeat_) / period());
  }
  if (life_end_ > now) return Event::kNone;
  life_end_ = kNever;
  life_lost_ = true;
  return Event::kLost;
}

}  // namespace driveline::slaves::cia301
