#pragma once

#include "driveline/port/port.hpp"

namespace driveline::bench {

/// A port that can measure the time spent inside the underlying port.
class TimedPort final : public port::Port {
 public:
  explicit TimedPort(port::Port& inner) noexcept : inner_(inner) {}

  /// Resets the times to zero, and starts or stops measuring.
  void reset(bool measure) noexcept;
  /// Time since reset(), without the readings of the clock.
  [[nodiscard]] double inside_ns() const noexcept;
  /// The cost of measuring for the caller outside of inside_ns().
  [[nodiscard]] double overhead_ns() const noexcept;

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
  void hold_until(std::chrono::nanoseconds instant) noexcept override { inner_.hold_until(instant); }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override { return inner_.wait_readable(deadline); }
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return inner_.last_send_time(); }

 private:
  port::Port& inner_;
  bool measure_ = false;
  double measured_ns_ = 0.0;
  int calls_ = 0;
};

}  // namespace driveline::bench
