#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace driveline::rt {

/// A CPU switched to a thread.
struct CpuSwitch {
  std::chrono::nanoseconds time{};  ///< time of the switch, CLOCK_MONOTONIC
  std::int32_t thread = 0;          ///< thread id; 0: idle
};

/// Reason why there is no SwitchLog.
struct SwitchLogError {
  int cpu = 0;           ///< the CPU to be observed
  int error_number = 0;  ///< errno of the failed call
  /// The error as a sentence with the remedy.
  [[nodiscard]] std::string message() const;
};

/// The error as a sentence with the remedy.
[[nodiscard]] inline std::string describe(const SwitchLogError& error) {
  return error.message();
}

/// The threads that a CPU switched to, recorded by the kernel (perf_event_open(2): context switches of a CPU) in memory
/// that it shares with this process: the last 1,000 or so. Each switch costs about 0.3 us more while the log is open.
/// Interrupts of a thread, and the host of a virtual machine, do not appear.
class SwitchLog {
 public:
  /// Opens the log of `cpu`. Needs root or CAP_PERFMON.
  [[nodiscard]] static tl::expected<std::unique_ptr<SwitchLog>, SwitchLogError> open(int cpu);

  SwitchLog(const SwitchLog&) = delete;
  SwitchLog& operator=(const SwitchLog&) = delete;
  ~SwitchLog();

  /// Writes the switches after `since`, and the last one before it, to `found`, newest first, as many as fit. Returns
  /// their number. Call it on a thread of that CPU, so that no switch happens meanwhile. \rtsafe
  [[nodiscard]] std::size_t read(std::chrono::nanoseconds since, std::span<CpuSwitch> found) const noexcept;

 private:
  SwitchLog(int descriptor, std::byte* memory) noexcept : descriptor_(descriptor), memory_(memory) {}

  int descriptor_;
  std::byte* memory_;
};

/// Name of a thread of this machine; empty if it has ended.
[[nodiscard]] std::string thread_name(std::int32_t thread);

}  // namespace driveline::rt
