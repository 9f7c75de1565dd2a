#include "driveline/motion/cycle/cycle_trace.hpp"

#include <gmock/gmock.h>
#include <pthread.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "driveline/rt/clock.hpp"

namespace driveline::motion {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr nanoseconds kTracePeriod = microseconds{125};

/// A cycle that wakes up `late` after its instant, after `missed` skipped ones, and whose phases take `each`.
void trace_cycle(CycleTrace& trace, std::int64_t number, nanoseconds each, nanoseconds late = {},
                 std::int64_t missed = 0) {
  const auto grid = number * kTracePeriod;
  trace.begin({number, grid, grid + late, missed}, kTracePeriod);
  auto now = grid + late;
  for (std::size_t phase = 0; phase < motion::kCyclePhases; ++phase) {
    now += each;
    trace.mark(static_cast<CyclePhase>(phase), now);
  }
  trace.end();
}

std::vector<std::int64_t> numbers(const std::vector<TracedCycle>& cycles) {
  std::vector<std::int64_t> list;
  for (const auto& cycle : cycles) list.push_back(cycle.stamps.cycle);
  return list;
}

/// Numbers of the worst cycles, by rank.
std::vector<std::int64_t> worst_of(std::vector<TracedCycle> cycles) {
  std::erase_if(cycles, [](const TracedCycle& cycle) { return cycle.rank == 0; });
  std::sort(cycles.begin(), cycles.end(), [](const auto& a, const auto& b) { return a.rank < b.rank; });
  for (std::size_t i = 0; i < cycles.size(); ++i) EXPECT_EQ(cycles[i].rank, i + 1);
  return numbers(cycles);
}

/// On one processor, which other threads use, too.
TEST(CycleTrace, AWorstCycleHasWhoHadItsProcessor) {
  const int cpu = sched_getcpu();
  auto log = rt::SwitchLog::open(cpu);
  if (!log) GTEST_SKIP() << log.error().message();
  CycleTrace trace(4);
  trace.watch(**log);
  std::int32_t self = 0;
  std::jthread([&] {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(cpu), &set);
    ASSERT_EQ(pthread_setaffinity_np(pthread_self(), sizeof set, &set), 0);
    self = static_cast<std::int32_t>(syscall(SYS_gettid));
    const rt::MonotonicClock clock;
    const auto due = clock.now();
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
    const auto wake = clock.now();
    trace.begin({0, due, wake, 0}, kTracePeriod);
    for (std::size_t phase = 0; phase < motion::kCyclePhases; ++phase)
      trace.mark(static_cast<CyclePhase>(phase), clock.now());
    trace.end();
  }).join();
  const auto cycle = trace.cycles().front();
  ASSERT_GE(cycle.switches.size(), 2U) << "it slept, and was woken";
  EXPECT_TRUE(std::is_sorted(cycle.switches.begin(), cycle.switches.end(),
                             [](const auto& a, const auto& b) { return a.time < b.time; }));
  EXPECT_EQ(cycle.switches.back().thread, self);
  EXPECT_GT(cycle.switches.back().time, cycle.stamps.due);
}

TEST(CycleTrace, HasNothingBeforeTheFirstCycle) {
  EXPECT_THAT(CycleTrace(4).cycles(), IsEmpty());
}

TEST(CycleTrace, HasWakeUpPhasesAndCostOfACycle) {
  CycleTrace trace(4);
  trace_cycle(trace, 7, nanoseconds{100}, nanoseconds{40});
  const auto cycles = trace.cycles();
  ASSERT_EQ(cycles.size(), 1U);
  const auto& stamps = cycles[0].stamps;
  EXPECT_EQ(stamps.due, 7 * kTracePeriod);
  EXPECT_EQ(stamps.wake - stamps.due, nanoseconds{40});
  EXPECT_EQ(stamps.end.front() - stamps.wake, nanoseconds{100});
  EXPECT_EQ(stamps.cost(), nanoseconds{700}) << "without the publishing";
  EXPECT_EQ(stamps.span(), nanoseconds{840});
  EXPECT_EQ(cycles[0].rank, 1U);
}

TEST(CycleTrace, AnAbsenceCountsFromTheFirstInstantThatWasMissed) {
  CycleTrace trace(4);
  trace_cycle(trace, 10, nanoseconds{100}, nanoseconds{40}, 3);
  const auto stamps = trace.cycles()[0].stamps;
  EXPECT_EQ(stamps.missed, 3);
  EXPECT_EQ(stamps.due, 7 * kTracePeriod);
  EXPECT_EQ(stamps.span(), 3 * kTracePeriod + nanoseconds{840});
}

TEST(CycleTrace, KeepsTheLastCyclesOldestFirst) {
  CycleTrace trace(CycleTrace::kWorst + 4);
  for (int i = 0; i < 100; ++i) trace_cycle(trace, i, nanoseconds{100});
  const auto list = numbers(trace.cycles());
  ASSERT_GE(list.size(), CycleTrace::kWorst + 4);
  for (std::size_t i = 0; i < CycleTrace::kWorst + 4; ++i) {
    EXPECT_EQ(list[list.size() - 1 - i], 99 - static_cast<int>(i));
  }
}

TEST(CycleTrace, KeepsTheWorstCyclesWholeHoweverLongAgo) {
  CycleTrace trace(3);
  for (int i = 0; i < 10'000; ++i) {
    // 16 bad ones at 500, 1000, ...: each a little worse than the previous one. The worst one is late, not slow.
    const bool bad = i % 500 == 0 && i > 0 && i <= 8000;
    trace_cycle(trace, i, bad ? nanoseconds{10'000 + i} : nanoseconds{100},
                i == 3000 ? microseconds{90} : nanoseconds{});
  }
  const auto cycles = trace.cycles();
  std::vector<std::int64_t> expected{3000};
  for (int i = 8000; i > 0; i -= 500) {
    if (i != 3000) expected.push_back(i);
  }
  EXPECT_EQ(worst_of(cycles), expected);
  const auto worst = std::find_if(cycles.begin(), cycles.end(), [](const auto& cycle) { return cycle.rank == 1; });
  EXPECT_EQ(worst->stamps.wake - worst->stamps.due, microseconds{90});
  EXPECT_EQ(worst->stamps.cost(), 7 * nanoseconds{13'000});
  const auto list = numbers(cycles);
  EXPECT_TRUE(std::is_sorted(list.begin(), list.end()));
  EXPECT_EQ(list.size(), 16U + 3U);
  EXPECT_EQ(list.back(), 9999);
}

TEST(CycleTrace, ACycleThatIsBothAmongTheLastAndTheWorstIsThereOnce) {
  CycleTrace trace(4);
  for (int i = 0; i < 4; ++i) trace_cycle(trace, i, nanoseconds{100 * (4 - i)});
  EXPECT_THAT(numbers(trace.cycles()), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(worst_of(trace.cycles()), ElementsAre(0, 1, 2, 3));
}

TEST(CycleTrace, ForgetsEverythingWhenItIsCleared) {
  CycleTrace trace(4);
  for (int i = 0; i < 40; ++i) trace_cycle(trace, i, microseconds{50});
  trace.clear();
  EXPECT_THAT(trace.cycles(), IsEmpty());
  trace_cycle(trace, 41, nanoseconds{100});
  EXPECT_THAT(worst_of(trace.cycles()), ElementsAre(41));
}

}  // namespace
}  // namespace driveline::motion
