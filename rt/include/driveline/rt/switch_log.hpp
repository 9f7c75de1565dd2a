#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>

namespace driveline::rt {

/// A thread got a CPU.
struct CpuSwitch {
  std::chrono::nanoseconds time{};  ///< CLOCK_MONOTONIC
  std::int32_t thread = 0;          ///< its number; 0: idle
};

/// Why there is no SwitchLog.
struct SwitchLogError {
  int cpu = 0;           ///< that was to be seen
  int error_number = 0;  ///< of the kernel
  /// A sentence with the remedy.
  [[nodiscard]] std::string message() const;
};

/// Which threads a CPU went to, as the kernel writes it down (perf_event_open(2): context switches of a CPU) into
/// memory that it shares with this process: the last 1,000 of them. Each switch costs the kernel some 0.3 us more
/// meanwhile. What interrupts it, and the host of a virtual machine, are not seen.
class SwitchLog {
 public:
  /// Of `cpu`. Needs root or CAP_PERFMON.
  [[nodiscard]] static tl::expected<std::unique_ptr<SwitchLog>, SwitchLogError> open(int cpu);

  SwitchLog(const SwitchLog&) = delete;
  SwitchLog& operator=(const SwitchLog&) = delete;
  ~SwitchLog();

  /// Puts the switches after `since`, and the last one before it, into `found`, newest first; at most as many as
  /// there is room for. Returns how many. For a thread on that CPU, which no switch meets meanwhile. \rtsafe
  [[nodiscard]] std::size_t look(std::chrono::nanoseconds since, std::span<CpuSwitch> found) const noexcept;

 private:
  SwitchLog(int descriptor, std::byte* memory) noexcept : descriptor_(descriptor), memory_(memory) {}

  int descriptor_;
  std::byte* memory_;
};

/// What a thread of this machine calls itself; empty: it has ended.
[[nodiscard]] std::string thread_name(std::int32_t thread);

}  // namespace driveline::rt
