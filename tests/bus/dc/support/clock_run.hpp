#pragma once

#include <functional>
#include <random>

#include "clock_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {

/// A clock whose sleepers wake up late, by `latency`.
class LateClock final : public rt::Clock {
 public:
  LateClock(rt::VirtualClock& inner, std::function<nanoseconds()> latency)
      : inner_(inner), latency_(std::move(latency)) {}
  [[nodiscard]] nanoseconds now() const noexcept override { return inner_.now(); }
  void sleep_until(nanoseconds deadline) noexcept override { inner_.sleep_until(deadline + latency_()); }
  void spin() noexcept override { inner_.spin(); }

 private:
  rt::VirtualClock& inner_;
  std::function<nanoseconds()> latency_;
};

/// A line of clocks in OP with a cycling master, and the true times of frames and SYNC0.
class ClockRun {
 public:
  struct Options {
    std::function<nanoseconds()> latency;  ///< latency of wake-ups; empty: none
    port::Port* port = nullptr;            ///< used instead of the line
    nanoseconds clock_timeout = seconds{2};
    port::RedundantPort* ring = nullptr;  ///< the ring behind `port`
    bool process_data = true;             ///< false: the slaves stay in PREOP, and the cycle only distributes the time
    nanoseconds early{};                  ///< lead of the cycle over the instant; needs a HoldingPort
  };

  explicit ClockRun(ClockLine& line) : ClockRun(line, Options{}) {}
  ClockRun(ClockLine& line, const Options& options);

  /// Takes the line to OP, or to PREOP without process data; returns the sentence of the error, empty on success.
  [[nodiscard]] std::string start(const ecat_master::dc::ClockPlan& plan);
  /// Runs one cycle.
  void cycle() { master_->pass(nanoseconds{1}); }
  /// Runs cycles for `duration` and polls the watch like an application; calls `each` after every cycle.
  void run(nanoseconds duration, const std::function<void()>& each = {});

  /// Lateness of the last cyclic frame at the reference clock, in the time of that clock, relative to the planned phase
  /// between frame and SYNC0.
  [[nodiscard]] nanoseconds arrival_error();
  /// The arrival error without the deviation of the sending from the grid instant.
  [[nodiscard]] nanoseconds grid_error();
  /// Grid instant of the last cycle, as the master sees it.
  [[nodiscard]] nanoseconds grid() const { return grid_; }
  /// The largest true distance of the last SYNC0 pulse of any slave from that of the reference clock.
  [[nodiscard]] nanoseconds worst_sync0();

  [[nodiscard]] ecat_master::Master& master() { return *master_; }
  [[nodiscard]] ecat_master::dc::ClockWatch& watch() { return *master_->clock_watch(); }
  [[nodiscard]] ecat_master::dc::ClockFollower::Status status() { return master_->clock_follower()->status(); }
  [[nodiscard]] const ecat_master::dc::LineClocks& clocks() { return watch().clocks(); }
  [[nodiscard]] std::vector<std::string> events();
  [[nodiscard]] std::uint64_t frames() const { return probe_.frames; }
  [[nodiscard]] std::size_t cycles() { return master_->core()->cycles(); }

 private:
  /// Records when frames are sent.
  class Probe final : public PassingPort {
   public:
    explicit Probe(port::Port& inner) : PassingPort(inner) {}
    [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override;
    std::uint64_t frames = 0;
    nanoseconds cyclic_sent{};  ///< last frame that starts with the broadcast read of the AL status
  };
  /// Records the grid of the cycle that it runs.
  class Runner;

  ClockLine& line_;
  Probe probe_;
  LateClock clock_;
  std::unique_ptr<ecat_master::Master> master_;
  nanoseconds grid_{};
  bool process_data_;
  nanoseconds early_;
};

}  // namespace driveline::bus_test
