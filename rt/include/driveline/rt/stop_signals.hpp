#pragma once

namespace driveline::rt {

/// \file
/// How a program that must end in order treats signals. All of the process, once.

/// From now on SIGINT, SIGTERM and SIGHUP ask for an orderly end instead of ending the process; a second one ends it at
/// once. SIGPIPE is ignored: a closed pipe on stdout must not leave the drives without a master.
void catch_stop_signals();

/// From now on writing beyond the file size limit (ulimit -f) is an error like a full disk and does not end the
/// process.
void refuse_long_files_with_errors();

/// Whether a signal has asked for the end. Any thread. \rtsafe
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace driveline::rt
