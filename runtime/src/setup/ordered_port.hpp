#pragma once

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/setup/line_orders.hpp"

namespace driveline::runtime {

/// The port of a simulated line in this process. It executes the commands of LineOrders before a frame enters the line,
/// on the thread that sends the frame: no other thread touches the line.
class OrderedPort final : public port::Port {
 public:
  /// All must outlive the port.
  OrderedPort(port::Port& line, LineOrders& orders, const rt::Clock& clock) noexcept
      : line_(line), orders_(orders), clock_(clock) {}

  /// \rtsafe
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    if (orders_.pending()) orders_.carry_out(clock_.now());
    return line_.send(frame);
  }
  /// \rtsafe
  void hold_until(std::chrono::nanoseconds instant) noexcept override { line_.hold_until(instant); }
  /// \rtsafe
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override { return line_.receive(); }
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override { return line_.wait_readable(deadline); }
  /// \rtsafe
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return line_.last_send_time(); }

 private:
  port::Port& line_;
  LineOrders& orders_;
  const rt::Clock& clock_;
};

}  // namespace driveline::runtime
