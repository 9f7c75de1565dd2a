#include "driveline/rt/wake_margin.hpp"

#include <gtest/gtest.h>

#include <random>

#include "driveline/rt/cycle_timer.hpp"

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kMarginPeriod = 125us;

TEST(WakeMargin, IsNothingUntilAWakeUpWasLate) {
  WakeMargin margin(31us);
  for (int i = 0; i < 1000; ++i) margin.observe(0ns);
  EXPECT_EQ(margin.value(), 0ns);
}

TEST(WakeMargin, CoversNinetyNineOfAHundred) {
  // 0 to 20 us, uniformly distributed: the percentile is known.
  std::mt19937 random(1);
  std::uniform_int_distribution<std::int64_t> took(0, 20'000);
  WakeMargin margin(31us);
  for (int i = 0; i < 20'000; ++i) margin.observe(nanoseconds{took(random)});
  int covered = 0;
  constexpr int kWakeUps = 100'000;
  for (int i = 0; i < kWakeUps; ++i) {
    const nanoseconds time{took(random)};
    covered += time <= margin.value() ? 1 : 0;
    margin.observe(time);
  }
  EXPECT_NEAR(static_cast<double>(covered) / kWakeUps, 0.99, 0.003);
}

TEST(WakeMargin, FollowsAMachineThatBecomesSlowerAndFaster) {
  WakeMargin margin(31us);
  for (int i = 0; i < 60; ++i) margin.observe(25us);
  EXPECT_GE(margin.value(), 25us);
  for (int i = 0; i < 5000; ++i) margin.observe(2us);
  EXPECT_LT(margin.value(), 3us);
  EXPECT_GE(margin.value(), 1990ns);
}

TEST(WakeMargin, OneLongWakeUpIsOneStep) {
  WakeMargin margin(31us);
  for (int i = 0; i < 1000; ++i) margin.observe(5us);
  const auto before = margin.value();
  margin.observe(300ms);
  EXPECT_LT(margin.value() - before, 1us);
}

TEST(WakeMargin, IsNeverLongerThanItMay) {
  WakeMargin margin(31us);
  for (int i = 0; i < 1000; ++i) margin.observe(1ms);
  EXPECT_EQ(margin.value(), 31us);
}

/// Each sleep ends late, by a time between two bounds, like on a virtual machine.
class DrowsyClock final : public Clock {
 public:
  [[nodiscard]] nanoseconds now() const noexcept override { return now_; }
  void sleep_until(nanoseconds deadline) noexcept override {
    if (now_ >= deadline) return;
    now_ = deadline + nanoseconds{std::uniform_int_distribution<std::int64_t>(least_.count(), most_.count())(random_)};
  }
  void spin() noexcept override { now_ += 100ns; }
  void work(nanoseconds time) noexcept { now_ += time; }
  void oversleep(nanoseconds least, nanoseconds most) noexcept {
    least_ = least;
    most_ = most;
  }

 private:
  nanoseconds now_{};
  nanoseconds least_{};
  nanoseconds most_{};
  std::mt19937 random_{7};
};

TEST(AdaptiveTimer, SoonWakesInTimeWhateverAWakeUpTakes) {
  for (const auto most : {4us, 14us, 28us}) {
    DrowsyClock clock;
    clock.oversleep(most - 3us, most);
    CycleTimer timer(clock, kMarginPeriod, std::nullopt);
    timer.start(1ms);
    for (int i = 0; i < 200; ++i) timer.wait_next();
    int late = 0;
    constexpr int kCycles = 10'000;
    for (int i = 0; i < kCycles; ++i) {
      const auto start = timer.wait_next();
      // A turn of spinning may overrun the instant.
      late += start.wake - start.grid > 100ns ? 1 : 0;
      clock.work(20us);
    }
    EXPECT_LT(late, kCycles / 50);
    EXPECT_GT(timer.wake_ahead(), most - 3us);
    EXPECT_LT(timer.wake_ahead(), most + 1us);
    EXPECT_EQ(timer.missed_total(), 0);
    EXPECT_EQ(timer.forced_rests(), 0);
  }
}

/// Otherwise spinning would consume the sleep that the thread owes, and a period would be skipped for it.
TEST(AdaptiveTimer, WhatItLearnedDoesNotTakeTheSleepOfALongCycle) {
  for (const auto work : {95us, 100us, 105us}) {
    DrowsyClock clock;
    clock.oversleep(15us, 25us);
    CycleTimer timer(clock, kMarginPeriod, std::nullopt);
    timer.start(1ms);
    for (int i = 0; i < 20'000; ++i) {
      timer.wait_next();
      clock.work(work);
    }
    EXPECT_EQ(timer.forced_rests(), 0) << work.count();
    EXPECT_EQ(timer.missed_total(), 0) << work.count();
  }
}

TEST(AdaptiveTimer, SpinsForAQuarterOfThePeriodAtMost) {
  DrowsyClock clock;
  clock.oversleep(80us, 90us);
  CycleTimer timer(clock, kMarginPeriod, std::nullopt);
  timer.start(1ms);
  for (int i = 0; i < 1000; ++i) timer.wait_next();
  EXPECT_EQ(timer.wake_ahead(), CycleTimer::max_wake_ahead(kMarginPeriod));
}

TEST(AdaptiveTimer, ACycleThatTookTooLongIsNoWakeUpThatTookLong) {
  DrowsyClock clock;
  CycleTimer timer(clock, kMarginPeriod, std::nullopt);
  timer.start(1ms);
  for (int i = 0; i < 1000; ++i) {
    timer.wait_next();
    clock.work(130us);
  }
  EXPECT_LT(timer.wake_ahead(), 1us);
}

TEST(AdaptiveTimer, OnAClockWhoseSleepsEndInTimeNothingChanges) {
  VirtualClock fixed_clock;
  VirtualClock adaptive_clock;
  CycleTimer fixed(fixed_clock, kMarginPeriod);
  CycleTimer adaptive(adaptive_clock, kMarginPeriod, std::nullopt);
  for (int i = 0; i < 1000; ++i) {
    const auto expected = fixed.wait_next();
    const auto start = adaptive.wait_next();
    ASSERT_EQ(start.wake, expected.wake);
    ASSERT_EQ(start.grid, expected.grid);
    fixed_clock.advance(nanoseconds{i * 100});
    adaptive_clock.advance(nanoseconds{i * 100});
  }
  EXPECT_EQ(adaptive.wake_ahead(), 0ns);
}

TEST(AdaptiveTimer, AFixedTimeStaysWhatItIs) {
  DrowsyClock clock;
  clock.oversleep(80us, 90us);
  CycleTimer timer(clock, kMarginPeriod, 10us);
  timer.start(1ms);
  for (int i = 0; i < 1000; ++i) timer.wait_next();
  EXPECT_EQ(timer.wake_ahead(), 10us);
}

}  // namespace
}  // namespace driveline::rt
