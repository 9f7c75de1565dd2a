#include "driveline/canopen_master/acyclic_port.hpp"

#include <algorithm>
#include <utility>

namespace driveline::canopen {

using std::chrono::nanoseconds;

AcyclicPort::AcyclicPort(AcyclicChannel& channel, rt::Clock& clock, nanoseconds step, Pass pass)
    : channel_(&channel), clock_(&clock), step_(step), pass_(std::move(pass)) {}

SendStatus AcyclicPort::send(const Frame& frame) noexcept {
  if (!frame.valid()) return SendStatus::kNotValid;
  if (channel_->statistics().down) return SendStatus::kDown;
  return channel_->request(frame) ? SendStatus::kSent : SendStatus::kBusy;
}

std::optional<ReceivedFrame> AcyclicPort::receive() noexcept {
  ReceivedFrame frame;
  if (!channel_->take(frame)) return std::nullopt;
  return frame;
}

bool AcyclicPort::wait_readable(nanoseconds deadline) noexcept {
  for (;;) {
    if (channel_->waiting()) return true;
    const nanoseconds now = clock_->now();
    if (now >= deadline) return false;
    if (!told_down_ && channel_->statistics().down) {
      told_down_ = true;
      return false;
    }
    const nanoseconds step = std::min(step_, deadline - now);
    if (pass_) {
      pass_(step);
    } else {
      clock_->sleep_until(now + step);
    }
  }
}

PortStatistics AcyclicPort::statistics() const noexcept {
  auto statistics = channel_->statistics();
  statistics.lost += channel_->lost();
  return statistics;
}

void PassingClock::sleep_until(nanoseconds deadline) noexcept {
  const nanoseconds now = clock_->now();
  if (deadline <= now) return;
  if (pass_) {
    pass_(deadline - now);
  } else {
    clock_->sleep_until(deadline);
  }
}

}  // namespace driveline::canopen
