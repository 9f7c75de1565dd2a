#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <tl/expected.hpp>

#include "driveline/rt/cpu_latency.hpp"
#include "driveline/rt/realtime_report.hpp"

namespace driveline::rt {

/// What to do if a requested real-time setting is not in effect.
enum class RealtimePolicy {
  kEnforce,  ///< do not run the task; start() returns the error with the remedies
  kDegrade,  ///< run the task anyway; the report states what is missing
};

/// Set-up of a real-time thread. The defaults request every setting except a CPU, which only the user can choose.
struct RealtimeConfig {
  RealtimePolicy policy = RealtimePolicy::kEnforce;  ///< reaction if a setting cannot be obtained
  std::string name = "driveline-rt";                 ///< name shown by `top -H`; the kernel stores 15 characters
  std::optional<int> priority = 80;      ///< SCHED_FIFO priority 1 .. 99; none: the scheduling class is not changed
  std::optional<int> cpu{};              ///< the only CPU to run on; none: the affinity is not changed
  bool lock_memory = true;               ///< lock the memory of the whole process and retain its heap
  std::size_t stack_bytes = 512 * 1024;  ///< stack size; the whole stack is touched before the task runs
  /// How much the kernel may delay a timer to save wake-ups, >= 1 ns (newer kernels do not delay SCHED_FIFO threads).
  std::chrono::nanoseconds timer_slack{1};
  /// Longest wake-up time of an idle CPU of the machine while the thread lives, see CpuLatencyHold; none: left to the
  /// kernel. A refused request is noted in the report and never prevents the start.
  std::optional<std::chrono::microseconds> cpu_latency{0};
  std::string cpu_latency_device = CpuLatencyHold::kDevice;  ///< tests use another file
};

/// The work of a real-time thread.
class RealtimeTask {
 public:
  virtual ~RealtimeTask() = default;

  /// Runs once the set-up is complete; the thread ends when it returns. Usually a loop around CycleTimer::wait_next()
  /// until a stop is requested. Querying `stop` is \rtsafe.
  virtual void run(std::stop_token stop) noexcept = 0;
};

/// A thread with a complete real-time set-up; it can refuse to start if a setting cannot be obtained.
///
/// Scheduling class, CPU, locked memory, resident stack, retained heap and timer slack are set, read back from the
/// kernel and reported; until join() idle CPUs are kept awake (CpuLatencyHold). All signals are blocked in the thread,
/// so that they interrupt other threads. Memory locking and heap settings affect the whole process and remain after the
/// thread has ended: everything mapped when start() is called is brought into memory at once, so create threads with
/// large stacks afterwards.
///
/// An object belongs to one (ordinary) thread; the real-time thread itself must not call its functions.
class RealtimeThread {
 public:
  RealtimeThread();
  /// Requests a stop and waits until the task has ended.
  ~RealtimeThread();
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  /// Creates the thread, sets it up, and runs `task`, which must outlive join(). Returns the report of the settings in
  /// effect when the set-up is done. Under RealtimePolicy::kEnforce an incomplete set-up is an error: the task does not
  /// run, and start() may be called again. A thread that cannot be created is an error under either policy.
  /// @throws std::logic_error if the thread is running already or was not joined.
  [[nodiscard]] tl::expected<RealtimeReport, RealtimeError> start(const RealtimeConfig& config, RealtimeTask& task);

  /// Requests the task to end. No effect if there is none.
  void request_stop() noexcept;

  /// Waits until the task has ended. No effect if there is none. Afterwards start() may be called again.
  void join() noexcept;

  /// Like join(), but waits for at most `timeout`. false: the task still runs, so the caller must not touch or destroy
  /// anything that it uses.
  [[nodiscard]] bool join_for(std::chrono::nanoseconds timeout);

 private:
  struct Launch;
  std::unique_ptr<Launch> launch_;  // exists while there is a thread to join
};

}  // namespace driveline::rt
