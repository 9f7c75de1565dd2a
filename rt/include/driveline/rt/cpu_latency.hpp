#pragma once

#include <chrono>
#include <string>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Keeps the CPUs of this machine out of sleep states with a long wake-up time.
///
/// The longer a CPU is idle the deeper it sleeps, and waking then takes up to 200 us: too long for a thread that wakes
/// every 125 us. The kernel honours the shortest limit that any process requests, as long as that process keeps the
/// device open (kernel documentation, "PM Quality Of Service Interface"), so the request ends with this object, or with
/// the process, even when the process is killed.
///
/// Affects the whole machine. One thread at a time; not for the cycle.
class CpuLatencyHold {
 public:
  /// Kernel device that accepts these requests.
  static constexpr const char* kDevice = "/dev/cpu_dma_latency";

  /// Makes no request yet.
  CpuLatencyHold() = default;
  /// Ends the request.
  ~CpuLatencyHold();
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;

  /// Requests that CPUs wake within `limit` after an interrupt; 0: CPUs do not sleep at all. Replaces the previous
  /// request. Tests pass another file as `device`. The returned item states the limit now in effect, read back: the
  /// shortest one that any process requests.
  [[nodiscard]] RealtimeItem request(std::chrono::microseconds limit, const std::string& device = kDevice);

  /// Withdraws the request, if any.
  void release() noexcept;

  /// The report item for a configuration without a request.
  [[nodiscard]] static RealtimeItem not_requested();

 private:
  int descriptor_ = -1;
};

}  // namespace driveline::rt
