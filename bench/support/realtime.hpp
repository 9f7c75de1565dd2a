#pragma once

#include "driveline/rt/realtime_thread.hpp"

namespace driveline::bench {

/// Starts `task` in a real-time thread as `driveline run` would: SCHED_FIFO, the last CPU, memory locked. Settings that
/// are not in effect are named on stderr. Throws std::runtime_error when the thread cannot be created.
void start_realtime(rt::RealtimeThread& thread, rt::RealtimeTask& task);

/// The calling thread on processor `cpu` and nowhere else, in SCHED_FIFO, ahead of ordinary work, which would otherwise
/// be measured as well. Both are read back; a setting that is not in effect is named on stderr. Threads that it creates
/// inherit both.
void claim_cpu(int cpu);
[[nodiscard]] int last_cpu() noexcept;

/// Rests of a thread in SCHED_FIFO that would never sleep: Linux stops one that takes more than 0.95 s of a second, for
/// the rest of it and in the middle of whatever is measured (sched(7), sched_rt_runtime_us), and on a machine with few
/// processors others have to get their turn.
class Rests {
 public:
  /// Sleeps when a rest is due; true if it has slept, so that the next measurement starts with cold caches.
  bool take_when_due(double now_ns) noexcept;

 private:
  double next_ns_ = 0.0;
};

}  // namespace driveline::bench
