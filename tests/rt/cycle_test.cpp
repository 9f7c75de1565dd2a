#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "driveline/rt/clock.hpp"
#include "driveline/rt/cycle_timer.hpp"
#include "driveline/rt/histogram.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/rt/spsc_ring.hpp"
#include "driveline/rt/triple_buffer.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "rt_support.hpp"

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// A cycle that uses every primitive of this library, on the real clock.
class WholeCycle final : public RealtimeTask {
 public:
  static constexpr int kCycles = 10'000;
  static constexpr nanoseconds kPeriod = 125us;

  void run(std::stop_token stop) noexcept override {
    first_ = clock_.now() + 1ms;
    timer_.start(first_);
    RtGuard::enter();
    for (int i = 0; i < kCycles && !stop.stop_requested(); ++i) {
      const CycleStart start = timer_.wait_next();
      latency.record(start.wake - start.grid);
      commands.update();
      ring.try_push(start);
      answers.write(start.cycle + commands.read());
      check(start);
    }
    counts = RtGuard::leave();
  }

  TripleBuffer<std::int64_t> commands{7};
  TripleBuffer<std::int64_t> answers{0};
  SpscRing<CycleStart> ring{1024};
  Histogram latency;
  RtGuard::Counts counts;
  std::int64_t off_grid = 0;
  std::int64_t early = 0;
  std::int64_t last_cycle = -1;
  std::int64_t miscounted = 0;

  [[nodiscard]] const CycleTimer& timer() const { return timer_; }

 private:
  void check(const CycleStart& start) noexcept {
    off_grid += start.grid != first_ + start.cycle * kPeriod ? 1 : 0;
    early += start.wake < start.grid ? 1 : 0;
    miscounted += start.cycle != last_cycle + 1 + start.missed ? 1 : 0;
    last_cycle = start.cycle;
  }

  MonotonicClock clock_;
  CycleTimer timer_{clock_, kPeriod, 25us};
  nanoseconds first_{};
};

TEST(RealtimeCycle, RunsOnTheGridWithoutHeapOrLock) {
  RealtimeConfig config;
  config.policy = RealtimePolicy::kDegrade;
  WholeCycle task;
  RealtimeThread thread;
  ASSERT_TRUE(thread.start(config, task).has_value());
  thread.join();

  EXPECT_EQ(task.latency.count(), static_cast<std::uint64_t>(WholeCycle::kCycles));
  EXPECT_EQ(task.off_grid, 0);
  EXPECT_EQ(task.early, 0);
  EXPECT_EQ(task.miscounted, 0);
  EXPECT_EQ(task.last_cycle + 1, WholeCycle::kCycles + task.timer().missed_total());
  EXPECT_EQ(task.ring.dropped() + task.ring.size(), static_cast<std::uint64_t>(WholeCycle::kCycles));
  ASSERT_TRUE(task.answers.update());
  EXPECT_EQ(task.answers.read(), task.last_cycle + 7);
  if (!RtGuard::available()) {
    GTEST_SKIP() << "heap and locks are not counted: a sanitizer owns them in this build";
  }
  EXPECT_EQ(task.counts.allocations, 0u);
  EXPECT_EQ(task.counts.frees, 0u);
  EXPECT_EQ(task.counts.locks, 0u);
}

}  // namespace
}  // namespace driveline::rt
