#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/rt/spsc_ring.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "driveline/snapshot/snapshot.hpp"

namespace driveline::snapshot {

/// Timing of a DrainThread.
struct DrainConfig {
  /// Pause between two passes over empty rings. The rings must hold what the cycle writes in this time and in the
  /// longest pause of the machine's scheduler; at a period of 125 µs a pass per millisecond finds eight cycles.
  std::chrono::nanoseconds period = std::chrono::milliseconds{1};
  /// Longest time for which `stop` empties rings that a producer still fills.
  std::chrono::nanoseconds stop_limit = std::chrono::seconds{1};
};

/// Why a DrainThread could not be started.
struct DrainStartError {
  std::error_code cause{};  ///< system error, because no thread could be created; none: the thread was started before
};

/// The error as a message.
[[nodiscard]] std::string describe(const DrainStartError& error);

/// The only reader of the telemetry rings: a thread of normal priority that takes the samples out and hands them to
/// every consumer in turn.
///
/// It polls, because waking a sleeping thread would cost the real-time writer a system call. Rings and consumers belong
/// to the caller and must outlive the thread.
class DrainThread {
 public:
  /// Reads nothing before `start`.
  DrainThread(rt::SpscRing<LineSample>& lines, rt::SpscRing<AxisSample>& axes, std::vector<SampleConsumer*> consumers,
              DrainConfig config = {});
  /// Stops the thread if it runs.
  ~DrainThread();
  DrainThread(const DrainThread&) = delete;
  DrainThread& operator=(const DrainThread&) = delete;

  /// Starts the thread; it can be started once. The thread leaves any real-time policy of the caller for normal
  /// scheduling.
  /// Not real-time safe.
  [[nodiscard]] tl::expected<void, DrainStartError> start();

  /// Empties the rings, lets the consumers finish and joins the thread. Safe to call twice. It waits for a busy
  /// consumer; when a producer still fills the rings after `stop_limit`, the remaining samples stay in them. Not
  /// real-time safe.
  void stop();

  /// Samples handed to the consumers and dropped so far. Any thread.
  [[nodiscard]] DrainCounters counters() const noexcept;

 private:
  void run();
  bool pass();  ///< true when the rings may hold more
  bool wait_for_stop(std::chrono::nanoseconds duration);

  static constexpr std::size_t kBatch = 256;          ///< samples handed to the consumers in one call
  static constexpr std::size_t kBatchesPerPass = 16;  ///< limit, so that full rings do not starve timed work

  rt::SpscRing<LineSample>& lines_;
  rt::SpscRing<AxisSample>& axes_;
  std::vector<SampleConsumer*> consumers_;
  DrainConfig config_;
  std::array<LineSample, kBatch> line_batch_;
  std::array<AxisSample, kBatch> axis_batch_;
  std::atomic<std::uint64_t> lines_handed_{0};
  std::atomic<std::uint64_t> axes_handed_{0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;  ///< guarded by mutex_
  bool started_ = false;   ///< used by the owner's thread only
  std::thread thread_;
};

}  // namespace driveline::snapshot
