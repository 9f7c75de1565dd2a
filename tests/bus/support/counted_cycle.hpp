// Cycles in the caller's thread whose use of a resource is counted, without that of the simulated line.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/motion/cycle/cycle_runner.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/thread_usage.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {

/// Locks the memory of the process as the real-time thread of `driveline run` does, with a stack that is deep enough
/// for the cycle. The kernel takes no page away, so every page fault has its cause in the process. Unlocks it at the
/// end.
class LockedMemory {
 public:
  LockedMemory();
  ~LockedMemory();
  LockedMemory(const LockedMemory&) = delete;
  LockedMemory& operator=(const LockedMemory&) = delete;
  /// Why page faults cannot be counted here; empty: they can.
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }

 private:
  std::string refusal_;
};

/// Page faults of the calling thread between open() and close(), as counted by the kernel.
class PageFaultLedger {
 public:
  void open() noexcept { before_ = rt::ThreadUsage::now(); }
  void close() noexcept {
    const auto more = rt::ThreadUsage::now().since(before_);
    minor += more.minor_faults;
    major += more.major_faults;
  }

  std::int64_t minor = 0;
  std::int64_t major = 0;
  std::uint64_t cycles = 0;

 private:
  rt::ThreadUsage before_{};
};

/// Counts every cycle in a ledger: open(), close() and `cycles`.
template <typename Ledger>
class CountedRunner final : public motion::CycleRunner {
 public:
  CountedRunner(ecat_master::CyclicCore& core, rt::Clock& clock, Ledger& ledger)
      : core_(core), clock_(clock), timer_(clock, core.settings().period), ledger_(ledger) {}

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override {
    timer_.start(core_.first_grid(clock_.now() + 4 * timer_.period()));
    return {};
  }
  void pass(std::chrono::nanoseconds duration) override {
    const auto end = clock_.now() + duration;
    do {
      ledger_.open();
      core_.cycle(timer_.wait_next());
      timer_.shift_phase(core_.grid_shift());
      ledger_.close();
      ++ledger_.cycles;
    } while (clock_.now() < end);
  }
  void stop() override {}

 private:
  ecat_master::CyclicCore& core_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
  Ledger& ledger_;
};

/// Closes the ledger while the simulated line works: it may use what the master's cycle must not.
template <typename Ledger>
class UncountedLine final : public PassingPort {
 public:
  UncountedLine(port::Port& inner, Ledger& ledger) : PassingPort(inner), ledger_(ledger) {}

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    ledger_.close();
    const auto status = inner_.send(frame);
    ledger_.open();
    return status;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    ledger_.close();
    const auto frame = inner_.receive();
    ledger_.open();
    return frame;
  }

 private:
  Ledger& ledger_;
};

}  // namespace driveline::bus_test
