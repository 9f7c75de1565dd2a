#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/slaves/line/line.hpp"

namespace driveline::cli {

/// A change of a slave's AL state, as the server's owner hears of it.
struct StateChange {
  std::uint16_t slave = 0;
  wire::AlStatus status;
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;
};

/// Serves a simulated line on a port: every frame that comes in passes all slaves and goes back. The slaves live on
/// while no frames come. Runs in a real-time thread.
class LineServer final : public rt::RealtimeTask {
 public:
  LineServer(slaves::Line& line, port::Port& port, rt::Clock& clock);

  void run(std::stop_token stop) noexcept override;

  // Any thread.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t send_failures() const noexcept { return send_failures_.load(std::memory_order_relaxed); }
  /// The next change of state that has not been told yet; one thread.
  [[nodiscard]] bool next_change(StateChange& change) noexcept { return changes_.try_pop(change); }

  /// Receive to send of each frame; only while the server does not run.
  [[nodiscard]] const rt::Histogram& turn_around() const noexcept { return turn_around_; }

 private:
  void serve(const port::ReceivedFrame& frame) noexcept;
  void watch_states() noexcept;

  slaves::Line& line_;
  port::Port& port_;
  rt::Clock& clock_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
  std::vector<wire::AlStatus> states_;
  rt::SpscRing<StateChange> changes_;
  rt::Histogram turn_around_;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> send_failures_{0};
};

}  // namespace driveline::cli
