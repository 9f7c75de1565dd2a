#pragma once

#include <chrono>
#include <optional>

#include "driveline/rt/realtime_report.hpp"

/// The individual steps of the real-time set-up. Each one makes a setting, reads back the value in effect, and reports
/// it.
namespace driveline::rt::setup {

/// Locks the memory of the process: current mappings are brought into memory at once and stay there; later mappings
/// stay once they are touched.
[[nodiscard]] RealtimeItem lock_memory(bool requested);

/// Retains freed heap memory in the process and serves large blocks from the heap, so that resident memory is reused
/// instead of being returned and faulted in again.
[[nodiscard]] RealtimeItem keep_heap(bool requested);

/// Brings the whole stack of the calling thread (created by pthread_create) into memory.
[[nodiscard]] RealtimeItem prefault_stack();

/// Sets the timer slack of the calling thread.
[[nodiscard]] RealtimeItem set_timer_slack(std::chrono::nanoseconds slack);

/// Pins the calling thread to one CPU.
[[nodiscard]] RealtimeItem pin_to_cpu(std::optional<int> cpu);

/// Gives the calling thread a SCHED_FIFO priority.
[[nodiscard]] RealtimeItem set_scheduler(std::optional<int> priority);

/// The report item for a thread that could not be created.
[[nodiscard]] RealtimeItem no_thread(int error_number);

}  // namespace driveline::rt::setup
