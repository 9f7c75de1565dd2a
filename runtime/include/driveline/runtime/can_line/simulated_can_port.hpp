#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "driveline/canopen_port/can_port.hpp"
#include "driveline/canopen_port/open_can_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/can_line/can_line_calls.hpp"
#include "driveline/runtime/can_line/can_line_config.hpp"

namespace driveline::runtime {

/// A port to a CAN line that is simulated in this process: a node at the end of the cable, which takes part in
/// arbitration and acknowledges. The time of the bus is that of the clock since the port was opened, real or virtual;
/// every call does what is due on the bus, and wait_readable() moves a virtual clock from event to event. The drives
/// allocate nothing after their start.
class SimulatedCanPort final : public canopen::CanPort {
 public:
  /// Frames that wait for receive() at most; more are lost and counted.
  static constexpr std::size_t kQueueFrames = 4096;

  /// The bit rate is that of the line; of the options, all others count. `clock` must outlive the
  /// port.
  SimulatedCanPort(const CanLineConfig& config, const canopen::CanPortOptions& options, rt::Clock& clock);
  SimulatedCanPort(const SimulatedCanPort&) = delete;
  SimulatedCanPort& operator=(const SimulatedCanPort&) = delete;
  ~SimulatedCanPort() override;

  [[nodiscard]] canopen::SendStatus send(const canopen::Frame& frame) noexcept override;
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override;
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override;
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override;

  /// Returns the line, to inject faults or to look at its bus; its time is advanced by the port alone.
  [[nodiscard]] CanLine& line() noexcept {
    settled_at_.reset();
    return line_;
  }
  /// Returns the way to the line for a thread that does not use the port.
  [[nodiscard]] CanLineCalls& calls() noexcept { return calls_; }

 private:
  class Adapter;

  void advance();
  void advance_line(std::chrono::nanoseconds now);

  CanLine line_;
  CanLineCalls calls_;
  rt::Clock* clock_;
  std::chrono::nanoseconds start_;
  std::optional<std::chrono::nanoseconds> settled_at_;  ///< time of the bus at which nothing is due any more
  std::unique_ptr<Adapter> adapter_;
};

/// Simulates the line of a description in this process and opens a port to it.
[[nodiscard]] std::unique_ptr<SimulatedCanPort> open_simulated_can_port(const CanLineConfig& config,
                                                                        const canopen::CanPortOptions& options,
                                                                        rt::Clock& clock);

}  // namespace driveline::runtime
