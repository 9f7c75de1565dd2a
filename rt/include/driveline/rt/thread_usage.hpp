#pragma once

#include <cstdint>

namespace driveline::rt {

/// Kernel counters of one thread that show what interrupts a real-time thread and what it waits for. Not \rtsafe: a
/// system call; read them before the first cycle and after the last one.
struct ThreadUsage {
  /// Page faults without disk access: memory that was not resident when first touched. Should be 0.
  std::int64_t minor_faults = 0;
  std::int64_t major_faults = 0;        ///< page faults that waited for a disk: milliseconds each
  std::int64_t voluntary_switches = 0;  ///< times the thread went to sleep: one per cycle is normal
  /// Times another thread took the CPU: a thread of the same or a higher priority, or one of the kernel.
  std::int64_t involuntary_switches = 0;

  /// Reads the counters of the calling thread since its start (getrusage(2), RUSAGE_THREAD).
  [[nodiscard]] static ThreadUsage now() noexcept;
  /// Difference between this reading and the `earlier` one.
  [[nodiscard]] constexpr ThreadUsage since(const ThreadUsage& earlier) const noexcept {
    return {minor_faults - earlier.minor_faults, major_faults - earlier.major_faults,
            voluntary_switches - earlier.voluntary_switches, involuntary_switches - earlier.involuntary_switches};
  }
};

}  // namespace driveline::rt
