#pragma once

#include <deque>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen::port_test {

/// A port that accepts every frame, or returns a given status, and delivers the frames of a test.
class ScriptedCanPort final : public CanPort {
 public:
  explicit ScriptedCanPort(const rt::Clock& clock) : clock_(clock) {}

  SendStatus send(const Frame& /*frame*/) noexcept override { return status; }
  std::optional<ReceivedFrame> receive() noexcept override {
    if (next == arriving.size()) return std::nullopt;
    return ReceivedFrame{arriving[next++], clock_.now()};
  }
  bool wait_readable(std::chrono::nanoseconds /*deadline*/) noexcept override { return next != arriving.size(); }
  PortStatistics statistics() const noexcept override { return counters; }

  PortStatistics counters;
  SendStatus status = SendStatus::kSent;
  std::deque<Frame> arriving;
  std::size_t next = 0;

 private:
  const rt::Clock& clock_;
};

}  // namespace driveline::canopen::port_test
