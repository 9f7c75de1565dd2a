#pragma once

#include "driveline/rt/realtime_thread.hpp"

namespace driveline::bench {

/// Starts `task` in a real-time thread as `driveline run` would: SCHED_FIFO, the last CPU, memory locked. What of it is
/// not in effect is said on stderr. Throws std::runtime_error when there is no thread at all.
void start_realtime(rt::RealtimeThread& thread, rt::RealtimeTask& task);

/// The calling thread alone on processor `cpu`, ahead of ordinary work where that is allowed: whoever has to share it
/// measures others. Threads that it makes begin with the same.
void claim_cpu(int cpu) noexcept;
[[nodiscard]] int last_cpu() noexcept;

}  // namespace driveline::bench
