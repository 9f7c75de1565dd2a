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
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/slaves/line/line.hpp"

namespace driveline::runtime {

/// A change of a slave's AL state, as the server's owner hears of it.
struct StateChange {
  std::uint16_t slave = 0;
  wire::AlStatus status;
  wire::AlStatusCode code = wire::AlStatusCode::kNoError;
};

/// What the server is asked to do with the line, and what became of it.
struct LineOrder {
  /// What is to be done: begin or heal a fault, heal all, set or read a signal of a device.
  enum class Verb : std::uint8_t { kBegin, kHeal, kHealAll, kSetSignal, kReadSignal };
  Verb verb = Verb::kBegin;
  slaves::Fault fault{};  ///< kBegin, kHeal
  bool done = false;      ///< of an answer: it was possible
  /// \name kSetSignal, kReadSignal: a signal that the device has, a value that it takes
  /// @{
  std::uint16_t slave = 0;
  slaves::SignalPlace signal{};
  double value = 0.0;  ///< to be set, or as it was read
  /// @}
};

/// Serves a simulated line on one or two ports: every frame that comes in passes the slaves and goes back where the
/// wiring leads it. What the slaves themselves have to do comes right after: they live at most 90 us behind the clock,
/// like a drive's firmware, and a frame is answered at once. Runs in a real-time thread.
class LineServer final : public rt::RealtimeTask {
 public:
  using Nanoseconds = std::chrono::nanoseconds;

  /// How it waits for frames.
  struct Settings {
    /// Look for frames without sleeping while a master cycles, but for an eighth of its cycle.
    bool busy_poll = false;
    /// Waits for a frame at any of the ports, or the deadline; empty: at the first port.
    std::function<void(Nanoseconds deadline)> wait;
  };

  /// `secondary` is the far end of the line, may be null. All must live as long as the server.
  LineServer(slaves::Line& line, port::Port& primary, port::Port* secondary, rt::Clock& clock, Settings settings);
  /// On one port, with the default settings.
  LineServer(slaves::Line& line, port::Port& port, rt::Clock& clock) : LineServer(line, port, nullptr, clock, {}) {}

  void run(std::stop_token stop) noexcept override;
  /// One turn of run(): what has come in is served, what is due is done; returns when to look again at the latest.
  /// \rtsafe as far as the slaves' mailboxes are.
  Nanoseconds turn() noexcept;

  // Any thread.
  /// Frames that were answered.
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_.load(std::memory_order_relaxed); }
  /// Answers that the port did not take, or that found no place to wait in.
  [[nodiscard]] std::uint64_t send_failures() const noexcept { return send_failures_.load(std::memory_order_relaxed); }

  // One thread, the owner's.
  /// The next change of state that has not been told yet.
  [[nodiscard]] bool next_change(StateChange& change) noexcept { return changes_.try_pop(change); }
  /// False when too many orders wait already.
  [[nodiscard]] bool order(const LineOrder& order) noexcept { return orders_.try_push(order); }
  /// What became of the oldest order that was not told yet.
  [[nodiscard]] bool next_answer(LineOrder& answer) noexcept { return answers_.try_pop(answer); }
  /// Asks for the turn-around times since the last window; take_window() has them a moment later.
  void request_window() noexcept;
  /// False: request_window() has not been followed yet.
  [[nodiscard]] bool take_window(rt::Histogram& window) noexcept;
  /// Receive to send of all frames but those that a fault has delayed; only while the server does not run.
  [[nodiscard]] rt::Histogram turn_around() const noexcept;

 private:
  enum class Window : std::uint8_t { kNone, kWanted, kReady };
  /// A reply that a fault keeps back, and those behind it.
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
  void carry_out(LineOrder order, Nanoseconds now) noexcept;
  void watch_states() noexcept;
  void rest(Nanoseconds until) noexcept;

  slaves::Line& line_;
  std::array<port::Port*, slaves::kMasterPortCount> ports_;
  rt::Clock& clock_;
  Settings settings_;
  std::array<std::byte, port::kMaxFrameBytes> buffer_{};
  std::vector<Held> held_;
  std::size_t first_held_ = 0;
  std::size_t held_count_ = 0;
  std::vector<wire::AlStatus> states_;
  Nanoseconds next_housekeeping_{0};

  // The slaves' own life, a few slaves at a time, so that frames do not wait for all of them.
  std::size_t next_slave_ = 0;  ///< 0: the round is complete
  Nanoseconds next_round_{0};
  bool round_wanted_ = false;

  // Busy polling: the master's cycle as its frames show it.
  Nanoseconds last_frame_{0};
  Nanoseconds burst_begin_{0};
  Nanoseconds interval_{0};
  bool rested_ = true;

  rt::SpscRing<StateChange> changes_;
  rt::SpscRing<LineOrder> orders_;
  rt::SpscRing<LineOrder> answers_;
  std::array<rt::Histogram, 2> windows_;
  std::size_t filled_ = 0;  ///< the window that the server records in
  std::size_t taken_ = 0;   ///< the window that the owner takes next
  std::atomic<Window> window_{Window::kNone};
  rt::Histogram told_;  ///< the owner's: all windows taken
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<std::uint64_t> send_failures_{0};
};

}  // namespace driveline::runtime
