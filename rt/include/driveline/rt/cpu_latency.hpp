#pragma once

#include <chrono>
#include <string>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Keeps the processors of this machine out of sleep states that they would be too slow to leave.
///
/// The longer a processor is idle the deeper it sleeps, and it takes up to 200 us to wake: too long for a thread that
/// wakes every 125 us. The kernel honours the shortest limit that any process asks for, as long as that process keeps
/// the device open (kernel documentation, "PM Quality Of Service Interface"), so the request ends with this object, or
/// with the process, even when it is killed.
///
/// Concerns the whole machine. One thread at a time; not for the cycle.
class CpuLatencyHold {
 public:
  /// Device file of the kernel that takes such requests.
  static constexpr const char* kDevice = "/dev/cpu_dma_latency";

  /// Makes no request yet.
  CpuLatencyHold() = default;
  /// Ends the request.
  ~CpuLatencyHold();
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;

  /// Asks for processors that are awake `limit` after an interrupt, instead of what was asked for before; 0: they do
  /// not sleep at all. `device` is another file in tests. The item says what is in effect now: the shortest limit that
  /// any process asks for, read back.
  [[nodiscard]] RealtimeItem request(std::chrono::microseconds limit, const std::string& device = kDevice);

  /// Ends the request, if there is one.
  void release() noexcept;

  /// The item of a report when nothing is asked for.
  [[nodiscard]] static RealtimeItem not_requested();

 private:
  int descriptor_ = -1;
};

}  // namespace driveline::rt
