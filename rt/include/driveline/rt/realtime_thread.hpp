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

/// What to do when a requested real-time setting is not in effect.
enum class RealtimePolicy {
  kEnforce,  ///< do not run the task; start() returns the error with the remedies
  kDegrade,  ///< run all the same; the report says what is missing
};

/// How a real-time thread is to be set up. The defaults request every setting but a CPU, which only the user can
/// choose.
struct RealtimeConfig {
  RealtimePolicy policy = RealtimePolicy::kEnforce;  ///< what happens when a setting cannot be had
  std::string name = "driveline-rt";                 ///< as seen in `top -H`; the kernel keeps 15 characters
  std::optional<int> priority = 80;                  ///< SCHED_FIFO priority 1 .. 99; none: scheduling is left alone
  std::optional<int> cpu{};                          ///< the one CPU to run on; none: affinity is left alone
  bool lock_memory = true;                           ///< lock the memory of the whole process and keep its heap
  std::size_t stack_bytes = 512 * 1024;              ///< all of it is touched before the task runs
  /// How much the kernel may delay a timer to save wake-ups, >= 1 ns (newer kernels do not delay SCHED_FIFO at all).
  std::chrono::nanoseconds timer_slack{1};
  /// How long an idle CPU of the machine may take to wake while the thread lives, see CpuLatencyHold; none: left to the
  /// kernel. A request that is refused is a note in the report, never a reason not to start.
  std::optional<std::chrono::microseconds> cpu_latency{0};
  std::string cpu_latency_device = CpuLatencyHold::kDevice;  ///< another file in tests
};

/// The work of a real-time thread.
class RealtimeTask {
 public:
  virtual ~RealtimeTask() = default;

  /// Runs once the set-up is complete, and is the whole life of the thread: usually a loop around
  /// CycleTimer::wait_next() until `stop` is requested. Asking `stop` is \rtsafe.
  virtual void run(std::stop_token stop) noexcept = 0;
};

/// A thread with a complete real-time set-up, which is refused where the set-up cannot be had.
///
/// Scheduling class, CPU, locked memory, resident stack, kept heap and timer slack are set, read back from the kernel
/// and reported; until join() idle CPUs are kept awake (CpuLatencyHold). All signals are blocked in the thread, so that
/// they interrupt others. Memory locking and heap settings concern the whole process and stay after the thread has
/// ended: everything mapped when start() is called is brought into memory at once, so threads with large stacks are
/// better created afterwards.
///
/// An object belongs to one (ordinary) thread; none of its functions is for the real-time thread itself.
class RealtimeThread {
 public:
  RealtimeThread();
  /// Requests the stop and waits for the task to end.
  ~RealtimeThread();
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  /// Creates the thread, sets it up, and runs `task`, which must live until join(). Returns when the set-up is done,
  /// with the report of what is in effect. Under RealtimePolicy::kEnforce an incomplete set-up is an error, the task
  /// does not run, and start() may be tried again. A thread that cannot be created is an error under either policy.
  /// @throws std::logic_error if the thread is running already or was not joined.
  [[nodiscard]] tl::expected<RealtimeReport, RealtimeError> start(const RealtimeConfig& config, RealtimeTask& task);

  /// Asks the task to end. Does nothing if there is none.
  void request_stop() noexcept;

  /// Waits until the task has ended. Does nothing if there is none. Afterwards start() may be used again.
  void join() noexcept;

  /// The same for at most `patience`; false: the task still runs, and nothing it works with may be touched or
  /// destroyed.
  [[nodiscard]] bool join_for(std::chrono::nanoseconds patience);

 private:
  struct Launch;
  std::unique_ptr<Launch> launch_;  // exists while there is a thread to join
};

}  // namespace driveline::rt
