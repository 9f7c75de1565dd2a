#include "driveline/snapshot/drain_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include <system_error>
#include <utility>

namespace driveline::snapshot {
namespace {

/// Passes up to `batches` batches of a ring to `hand_on`. Returns true when the ring may hold more.
template <class Sample, std::size_t kSize, class HandOn>
bool drain(rt::SpscRing<Sample>& ring, std::array<Sample, kSize>& buffer, std::size_t batches, const HandOn& hand_on) {
  for (std::size_t batch = 0; batch < batches; ++batch) {
    const std::size_t count = ring.pop(std::span<Sample>{buffer});
    if (count != 0) {
      hand_on(std::span<const Sample>{buffer.data(), count});
    }
    if (count < kSize) {
      return false;
    }
  }
  return true;
}

/// A new thread inherits its creator's scheduling policy; reading telemetry must never compete with the cycle.
void become_normal_thread() {
  const sched_param no_priority{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &no_priority);
  pthread_setname_np(pthread_self(), "dl-telemetry");
}

}  // namespace

std::string describe(const DrainStartError& error) {
  return error.cause ? "Cannot start the telemetry thread: " + error.cause.message() + "."
                     : "The telemetry thread was already started; it can be started only once.";
}

DrainThread::DrainThread(rt::SpscRing<LineSample>& lines, rt::SpscRing<AxisSample>& axes,
                         std::vector<SampleConsumer*> consumers, DrainConfig config)
    : lines_(lines), axes_(axes), consumers_(std::move(consumers)), config_(config) {}

DrainThread::~DrainThread() {
  stop();
}

tl::expected<void, DrainStartError> DrainThread::start() {
  if (started_) {
    return tl::unexpected(DrainStartError{});
  }
  try {
    thread_ = std::thread{[this] { run(); }};
  } catch (const std::system_error& error) {
    return tl::unexpected(DrainStartError{error.code()});
  }
  started_ = true;
  return {};
}

void DrainThread::stop() {
  if (!thread_.joinable()) {
    return;
  }
  {
    const std::lock_guard lock{mutex_};
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

DrainCounters DrainThread::counters() const noexcept {
  return {.lines = lines_handed_.load(std::memory_order_relaxed),
          .axes = axes_handed_.load(std::memory_order_relaxed),
          .lines_dropped = lines_.dropped(),
          .axes_dropped = axes_.dropped()};
}

void DrainThread::run() {
  become_normal_thread();
  bool more = false;
  while (!wait_for_stop(more ? std::chrono::nanoseconds::zero() : config_.period)) {
    more = pass();
  }
  const auto deadline = std::chrono::steady_clock::now() + config_.stop_limit;
  while (pass() && std::chrono::steady_clock::now() < deadline) {
  }
  for (SampleConsumer* consumer : consumers_) {
    consumer->finish(counters());
  }
}

bool DrainThread::pass() {
  const bool more_lines = drain(lines_, line_batch_, kBatchesPerPass, [this](std::span<const LineSample> batch) {
    lines_handed_.fetch_add(batch.size(), std::memory_order_relaxed);
    for (SampleConsumer* consumer : consumers_) {
      consumer->lines(batch);
    }
  });
  const bool more_axes = drain(axes_, axis_batch_, kBatchesPerPass, [this](std::span<const AxisSample> batch) {
    axes_handed_.fetch_add(batch.size(), std::memory_order_relaxed);
    for (SampleConsumer* consumer : consumers_) {
      consumer->axes(batch);
    }
  });
  for (SampleConsumer* consumer : consumers_) {
    consumer->pass_done(counters());
  }
  return more_lines || more_axes;
}

bool DrainThread::wait_for_stop(std::chrono::nanoseconds duration) {
  std::unique_lock lock{mutex_};
  return wake_.wait_for(lock, duration, [this] { return stopping_; });
}

}  // namespace driveline::snapshot
