#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/runtime/setup/line_orders.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::runtime {

/// Serves a simulated line on one or two ports: every received frame passes the slaves and leaves at the port to which
/// the wiring leads. A frame is answered at once; the slaves' firmware is simulated afterwards, at most 90 us later
/// than the clock. Runs in a real-time thread.
class LineServer final : public rt::RealtimeTask {
 public:
  using Nanoseconds = std::chrono::nanoseconds;

  /// How the server waits for frames.
  struct Settings {
    /// Polls for frames while a master cycles, and sleeps only for an eighth of its cycle.
    bool busy_poll = false;
    /// Waits for a frame at any of the ports, or the deadline; empty: at the first port.
    std::function<void(Nanoseconds deadline)> wait;
  };

  /// `secondary` is the far end of the line and may be null. All must outlive the server.
  LineServer(slaves::SimulatedLine& line, port::Port& primary, port::Port* secondary, rt::Clock& clock,
             Settings settings);
  /// Serves one port, with the default settings.
  LineServer(slaves::SimulatedLine& line, port::Port& port, rt::Clock& clock)
      : LineServer(line, port, nullptr, clock, {}) {}

  void run(std::stop_token stop) noexcept override;
  /// Runs one turn of run(): answers received frames and does the work that is due. Returns the latest time for the
  /// next turn.
  /// \rtsafe as far as the mailboxes of the slaves are.
  Nanoseconds turn() noexcept;

  // Called on any thread.
  /// Returns the number of answered frames.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_.load(std::memory_order_relaxed); }
  /// Returns the number of answers that the port refused, or that a fault delays while the queue of delayed answers is
  /// full.
  [[nodiscard]] std::uint64_t send_failures() const noexcept { return send_failures_.load(std::memory_order_relaxed); }

  // Called only on the thread of the owner.
  /// Returns the queue of commands to the line, and of its answers and changes of state.
  [[nodiscard]] LineOrders& orders() noexcept { return orders_; }
  /// Takes the next change of state; false: there is none.
  [[nodiscard]] bool next_change(StateChange& change) noexcept { return orders_.next_change(change); }
  /// Queues a command; false: the queue is full.
  [[nodiscard]] bool order(const LineOrder& order) noexcept { return orders_.order(order); }
  /// Takes the next answer to a command; false: there is none.
  [[nodiscard]] bool next_answer(LineOrder& answer) noexcept { return orders_.next_answer(answer); }
  /// Requests the turn-around times since the last window; take_window() returns them shortly afterwards.
  void request_window() noexcept;
  /// Takes the requested window; false: it is not ready yet.
  [[nodiscard]] bool take_window(rt::Histogram& window) noexcept;
  /// Returns the turn-around times of all frames except those delayed by a fault; call only while the server does not
  /// run.
  [[nodiscard]] rt::Histogram turn_around() const noexcept;

 private:
  enum class Window : std::uint8_t { kNone, kWanted, kReady };
  /// An answer that is delayed by a fault, or that waits for a delayed one.
  struct Held {
    std::array<std::byte, port::kMaxFrameBytes> bytes;
    std::size_t length = 0;
    std::size_t port = 0;
    Nanoseconds due{0};
  };
  static constexpr std::size_t kMaxHeld = 64;

  bool serve_ports() noexcept;
  void advance_some(Nanoseconds now) noexcept;
  void serve(const port::ReceivedFrame& frame, std::size_t port) noexcept;
  void reply(std::span<const std::byte> frame, std::size_t port) noexcept;
  void hold(std::span<const std::byte> frame, std::size_t port, Nanoseconds due) noexcept;
  void release_held(Nanoseconds now) noexcept;
  void housekeep(Nanoseconds now) noexcept;
  void rest(Nanoseconds until) noexcept;

  slaves::SimulatedLine& line_;
  std::array<port::Port*, slaves::kMasterPortCount> ports_;
  rt::Clock& clock_;
  Settings settings_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
  std::vector<Held> held_;
  std::size_t first_held_ = 0;
  std::size_t held_count_ = 0;
  Nanoseconds next_housekeeping_{0};

  // The slaves' firmware is advanced a few slaves at a time, so that frames do not wait for all of them.
  std::size_t next_slave_ = 0;  ///< 0: the round is complete
  Nanoseconds next_round_{0};
  bool round_wanted_ = false;

  // Busy polling: cycle of the master, estimated from its frames.
  Nanoseconds last_frame_{0};
  Nanoseconds burst_begin_{0};
  Nanoseconds interval_{0};
  bool rested_ = true;

  LineOrders orders_;
  std::array<rt::Histogram, 2> windows_;
  std::size_t filled_ = 0;  ///< window in which the server records
  std::size_t taken_ = 0;   ///< window that the owner takes next
  std::atomic<Window> window_{Window::kNone};
  rt::Histogram taken_windows_;  ///< used by the owner: all windows taken
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> send_failures_{0};
};

}  // namespace driveline::runtime
