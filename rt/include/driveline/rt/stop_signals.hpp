#pragma once

namespace driveline::rt {

/// \file
/// Signal handling of a program that must shut down in order. The functions affect the whole process; call them once.

/// From now on SIGINT, SIGTERM and SIGHUP request an orderly shutdown instead of ending the process; a second one ends
/// it at once. SIGPIPE is ignored: a closed pipe on stdout must not leave the drives without a master.
void catch_stop_signals();

/// From now on a write beyond the file size limit (ulimit -f) fails like a write to a full disk and does not end the
/// process.
void refuse_long_files_with_errors();

/// Whether a signal has requested the shutdown. Any thread. \rtsafe
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace driveline::rt
