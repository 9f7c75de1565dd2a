#include "support/timed_port.hpp"

#include "support/stopwatch.hpp"

namespace driveline::bench {

void TimedPort::reset(bool measure) noexcept {
  measure_ = measure;
  measured_ns_ = 0.0;
  calls_ = 0;
}

// A call reads the clock twice. One of the readings is between the two instants, the other one outside.
double TimedPort::inside_ns() const noexcept {
  return measured_ns_ - calls_ * reading_cost_ns();
}

double TimedPort::overhead_ns() const noexcept {
  return 2 * calls_ * reading_cost_ns();
}

port::SendStatus TimedPort::send(std::span<const std::byte> frame) noexcept {
  if (!measure_) return inner_.send(frame);
  const double begin = now_ns();
  const auto status = inner_.send(frame);
  measured_ns_ += now_ns() - begin;
  ++calls_;
  return status;
}

std::optional<port::ReceivedFrame> TimedPort::receive() noexcept {
  if (!measure_) return inner_.receive();
  const double begin = now_ns();
  const auto frame = inner_.receive();
  measured_ns_ += now_ns() - begin;
  ++calls_;
  return frame;
}

}  // namespace driveline::bench
