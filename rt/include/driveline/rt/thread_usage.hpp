#pragma once

#include <cstdint>

namespace driveline::rt {

/// What the kernel has counted of one thread: what interrupts a real-time thread and what it waits for. Not \rtsafe: a
/// system call; read it before the first cycle and after the last one.
struct ThreadUsage {
  /// Page faults that took no disk: memory that was not there when it was first touched. 0 is the aim.
  std::int64_t minor_faults = 0;
  std::int64_t major_faults = 0;        ///< page faults that waited for a disk: milliseconds each
  std::int64_t voluntary_switches = 0;  ///< the thread went to sleep: one per cycle is how it waits
  /// Another thread took the CPU away: one of the same or a higher priority, or the kernel's own.
  std::int64_t involuntary_switches = 0;

  /// Of the calling thread since it began (getrusage(2), RUSAGE_THREAD).
  [[nodiscard]] static ThreadUsage now() noexcept;
  /// What came between `earlier` and this.
  [[nodiscard]] constexpr ThreadUsage since(const ThreadUsage& earlier) const noexcept {
    return {minor_faults - earlier.minor_faults, major_faults - earlier.major_faults,
            voluntary_switches - earlier.voluntary_switches, involuntary_switches - earlier.involuntary_switches};
  }
};

}  // namespace driveline::rt
