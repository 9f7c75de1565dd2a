#pragma once

namespace driveline::cli {

/// From now on SIGINT, SIGTERM and SIGHUP ask for an orderly end instead of ending the process; a second one ends it at
/// once. SIGPIPE is ignored: that the reader of our messages has left is no reason to leave drives without a master.
void catch_stop_signals();

/// From now on a file that reaches the limit of the process (ulimit -f) is a write that fails, with a sentence like
/// that of a full disk, and does not end the process.
void refuse_long_files_with_errors();

/// Whether a signal has asked for the end.
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace driveline::cli
