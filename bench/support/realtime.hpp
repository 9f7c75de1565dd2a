#pragma once

#include "driveline/rt/realtime_thread.hpp"

namespace driveline::bench {

/// Starts `task` in a real-time thread as `driveline run` would: SCHED_FIFO, the last CPU, memory locked. Names
/// settings that are not in effect on stderr. Throws std::runtime_error if the thread cannot be created.
void start_realtime(rt::RealtimeThread& thread, rt::RealtimeTask& task);

/// Pins the calling thread to processor `cpu`, in SCHED_FIFO, above ordinary work, which would otherwise be measured as
/// well. Reads both back, and names a setting that is not in effect on stderr. Threads that it creates inherit both.
void claim_cpu(int cpu);
[[nodiscard]] int last_cpu() noexcept;

/// Rests for a SCHED_FIFO thread that would never sleep: Linux stops a thread that takes more than 0.95 s of a second
/// for the rest of it, in the middle of a measurement (sched(7), sched_rt_runtime_us), and on a machine with few
/// processors other threads need their turn.
class Rests {
 public:
  /// Sleeps if a rest is due; true: it has slept, so the next measurement starts with cold caches.
  bool take_when_due(double now_ns) noexcept;

 private:
  double next_ns_ = 0.0;
};

}  // namespace driveline::bench
