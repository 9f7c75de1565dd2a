#pragma once

#include "driveline/rt/realtime_thread.hpp"

namespace driveline::bench {

/// Starts `task` in a real-time thread as `driveline run` would: SCHED_FIFO, the last CPU, memory locked. What of it is
/// not in effect is said on stderr. Throws std::runtime_error when there is no thread at all.
void start_realtime(rt::RealtimeThread& thread, rt::RealtimeTask& task);

}  // namespace driveline::bench
