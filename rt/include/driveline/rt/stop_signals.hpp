#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>

namespace driveline::rt {

/// \file
/// Signal handling of a program that must shut down in order. The functions affect the whole process; call them once.

/// Distinguishes a request to stop from the demand to end at once. Several signals are often one request: timeout(1)
/// sends SIGTERM to the program and to its process group, and when a terminal is closed, both the kernel and the shell
/// send SIGHUP. Only a signal after a pause shows that the user does not want to wait any longer.
class StopRequest {
 public:
  /// Signals with shorter pauses between them are one request.
  static constexpr std::chrono::nanoseconds kPause = std::chrono::seconds{1};

  /// Notes a signal at the monotonic time `now`. Returns whether it demands the end at once. May be called in a signal
  /// handler. \rtsafe
  [[nodiscard]] bool note(std::chrono::nanoseconds now) noexcept {
    const auto before = last_.exchange(now.count(), std::memory_order_relaxed);
    return before != kNone && now.count() - before >= kPause.count();
  }
  /// Whether a signal was noted. Any thread. \rtsafe
  [[nodiscard]] bool requested() const noexcept { return last_.load(std::memory_order_relaxed) != kNone; }

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min();
  std::atomic<std::int64_t> last_{kNone};  ///< time of the last signal, ns
  static_assert(std::atomic<std::int64_t>::is_always_lock_free, "used in a signal handler");
};

/// From now on the signals that would end the process request an orderly shutdown instead; StopRequest decides when a
/// further one ends it at once. Exceptions: SIGQUIT and SIGKILL still end it at once, and so do signals that report an
/// error of the program (SIGSEGV, SIGABRT ...); a signal that is ignored or handled already stays so (nohup,
/// profilers). SIGPIPE is ignored: a closed pipe on stdout must not leave the drives without a master.
void catch_stop_signals();

/// From now on a write beyond the file size limit (ulimit -f) fails like a write to a full disk and does not end the
/// process.
void refuse_long_files_with_errors();

/// Whether a signal has requested the shutdown. Any thread. \rtsafe
[[nodiscard]] bool stop_requested() noexcept;

}  // namespace driveline::rt
