// A debug build reports a task that allocates in the cycle.
#include <gtest/gtest.h>

#include <memory>
#include <mutex>

#include "driveline/motion/cycle/cycle_task.hpp"
#include "driveline/rt_guard/rt_guard.hpp"

namespace driveline::ecat_master {
namespace {

/// Allocates or locks at a point chosen by the test.
struct Wasteful final : motion::CycleTask {
  void update(const motion::TaskCycle& now) noexcept override {
    if (now.cycle == 1) memory = std::make_unique<int>(5);
    if (now.cycle == 2) const std::scoped_lock lock(mutex);
  }
  std::unique_ptr<int> memory;
  std::mutex mutex;
};

struct Clean final : motion::CycleTask {
  void update(const motion::TaskCycle&) noexcept override { ++calls; }
  int calls = 0;
};

void run(motion::TaskSchedule& schedule, std::int64_t cycle, rt::Clock& clock) {
  schedule.begin({cycle, {}, {}, 0});
  motion::TaskCycle now;
  now.cycle = cycle;
  schedule.run(motion::TaskTiming::Order::kBeforeMotion, now, std::chrono::microseconds{125}, clock);
}

TEST(TaskGuard, HeapAndLocksAreCountedForTheTaskThatUsesThem) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
  rt::VirtualClock clock;
  motion::TaskSchedule schedule;
  Clean clean;
  Wasteful wasteful;
  schedule.add(clean, {});
  schedule.add(wasteful, {});
  run(schedule, 0, clock);
  EXPECT_EQ(schedule.figures(1).forbidden_calls, 0U);
  run(schedule, 1, clock);
  EXPECT_EQ(schedule.figures(1).forbidden_calls, 1U) << "operator new";
  run(schedule, 2, clock);
  EXPECT_EQ(schedule.figures(1).forbidden_calls, 2U) << "a mutex";
  EXPECT_EQ(schedule.figures(0).forbidden_calls, 0U);
  EXPECT_EQ(clean.calls, 3);
}

TEST(TaskGuard, TheCountOfAWholeCycleGoesOnAroundATask) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
  rt::VirtualClock clock;
  motion::TaskSchedule schedule;
  Wasteful wasteful;
  schedule.add(wasteful, {});
  rt::RtGuard::enter();
  run(schedule, 1, clock);
  auto more = std::make_unique<int>(6);
  const auto counts = rt::RtGuard::leave();
  EXPECT_EQ(schedule.figures(0).forbidden_calls, 1U);
  EXPECT_EQ(counts.allocations, 2U) << "the task's, and the one after it";
  EXPECT_EQ(*more, 6);
}

}  // namespace
}  // namespace driveline::ecat_master
