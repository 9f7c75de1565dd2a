#pragma once

namespace driveline::cli {

/// From now on SIGINT, SIGTERM and SIGHUP ask for an orderly end instead of ending the process; a second one ends it at
/// once. SIGPIPE is ignored: that the reader of our messages has left is no reason to leave drives without a master.
void catch_stop_signals();

/// Whether one of them has come.
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace driveline::cli
