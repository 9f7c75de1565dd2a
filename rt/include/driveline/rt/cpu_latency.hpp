#pragma once

#include <chrono>
#include <string>

#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// Keeps the processors of this machine out of sleep states that they would be too slow to leave.
///
/// An idle processor sleeps the deeper the longer nothing happens, and takes up to 200 us to be back: too long for a
/// thread that wakes every 125 us. The kernel keeps to the shortest time that somebody asks for as long as that one
/// holds its device open (kernel documentation, "PM Quality Of Service Interface"), so the request ends with this
/// object, or with the process, however that ends.
///
/// Concerns the whole machine. One thread at a time; not for the cycle.
class CpuLatencyHold {
 public:
  /// Where the kernel takes such requests.
  static constexpr const char* kDevice = "/dev/cpu_dma_latency";

  /// Asks for nothing yet.
  CpuLatencyHold() = default;
  /// Ends the request.
  ~CpuLatencyHold();
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;

  /// Asks for processors that are awake `limit` after an interrupt, instead of what was asked for before; 0: they do
  /// not sleep at all. `device` is another file in tests. The item says what is in effect now: the shortest time that
  /// anybody asks for, read back.
  [[nodiscard]] RealtimeItem request(std::chrono::microseconds limit, const std::string& device = kDevice);

  /// Ends the request. Does nothing without one.
  void release() noexcept;

  /// The item of a report when nothing is asked for.
  [[nodiscard]] static RealtimeItem not_requested();

 private:
  int descriptor_ = -1;
};

}  // namespace driveline::rt
