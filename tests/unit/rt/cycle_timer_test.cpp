#include "driveline/rt/cycle_timer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <random>
#include <stdexcept>

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr nanoseconds kPeriod = 125us;
constexpr nanoseconds kFirst = 1ms;

TEST(CycleTimer, WakesExactlyOnTheGridWhenNothingIsLate) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  for (int i = 0; i < 1000; ++i) {
    const CycleStart start = timer.wait_next();
    EXPECT_EQ(start.cycle, i);
    EXPECT_EQ(start.grid, kFirst + i * kPeriod);
    EXPECT_EQ(start.wake, start.grid);
    EXPECT_EQ(start.missed, 0);
    clock.advance(40us);
  }
  EXPECT_EQ(timer.missed_total(), 0);
  EXPECT_EQ(timer.forced_rests(), 0);
}

struct Lateness {
  nanoseconds late;  // beyond the next grid instant
  std::int64_t missed;

  friend std::ostream& operator<<(std::ostream& out, const Lateness& lateness) {
    return out << lateness.late.count() << "ns";
  }
};

class CycleTimerOverrun : public testing::TestWithParam<Lateness> {};

TEST_P(CycleTimerOverrun, SkipsWholePeriodsAndKeepsThePhase) {
  const auto [late, missed] = GetParam();
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  timer.wait_next();
  clock.advance(kPeriod + late);

  const CycleStart after = timer.wait_next();
  EXPECT_EQ(after.missed, missed);
  EXPECT_EQ(after.cycle, 1 + missed);
  EXPECT_EQ(after.grid, kFirst + (1 + missed) * kPeriod);
  EXPECT_EQ(after.wake, kFirst + kPeriod + late) << "starts at once";

  const CycleStart next = timer.wait_next();
  EXPECT_EQ(next.missed, 0);
  EXPECT_EQ(next.grid, kFirst + (2 + missed) * kPeriod);
  EXPECT_EQ(next.wake, next.grid);
  EXPECT_EQ(timer.missed_total(), missed);
}

INSTANTIATE_TEST_SUITE_P(Lateness, CycleTimerOverrun,
                         testing::Values(Lateness{0ns, 0}, Lateness{1ns, 0}, Lateness{kPeriod * 4 / 10, 0},
                                         Lateness{kPeriod - 1ns, 0}, Lateness{kPeriod, 1},
                                         Lateness{kPeriod * 12 / 10, 1}, Lateness{kPeriod * 37 / 10, 3}));

/// A clock that oversleeps like a virtual machine.
class SleepyClock final : public Clock {
 public:
  [[nodiscard]] nanoseconds now() const noexcept override { return now_; }
  void sleep_until(nanoseconds deadline) noexcept override {
    if (now_ < deadline) {
      now_ = deadline + oversleep_;
    }
  }
  void spin() noexcept override { now_ += 100ns; }
  void oversleep_by(nanoseconds time) { oversleep_ = time; }

 private:
  nanoseconds now_{};
  nanoseconds oversleep_{};
};

TEST(CycleTimer, PeriodsLostInTheSleepCountToo) {
  SleepyClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  clock.oversleep_by(kPeriod * 23 / 10);
  const CycleStart late = timer.wait_next();
  EXPECT_EQ(late.missed, 2);
  EXPECT_EQ(late.cycle, 2);
  EXPECT_EQ(late.grid, kFirst + 2 * kPeriod);
  EXPECT_EQ(late.wake, kFirst + kPeriod * 23 / 10);
  clock.oversleep_by(0ns);
  EXPECT_EQ(timer.wait_next().grid, kFirst + 3 * kPeriod);
}

TEST(CycleTimer, StartInThePastSkipsToNow) {
  VirtualClock clock{kFirst + kPeriod * 5 / 2};
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  const CycleStart start = timer.wait_next();
  EXPECT_EQ(start.cycle, 2);
  EXPECT_EQ(start.missed, 2);
  EXPECT_EQ(start.grid, kFirst + 2 * kPeriod);
}

TEST(CycleTimer, WithoutStartTheGridBeginsAtConstruction) {
  VirtualClock clock{7s};
  CycleTimer timer{clock, kPeriod};
  EXPECT_EQ(timer.wait_next().grid, 7s);
  EXPECT_EQ(timer.wait_next().grid, 7s + kPeriod);
}

TEST(CycleTimer, SmallShiftsMoveAllLaterInstantsAndAddUp) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  timer.wait_next();
  EXPECT_EQ(timer.shift_phase(300ns), 300ns);
  EXPECT_EQ(timer.shift_phase(-100ns), -100ns);
  EXPECT_EQ(timer.wait_next().grid, kFirst + kPeriod + 200ns);
  EXPECT_EQ(timer.wait_next().grid, kFirst + 2 * kPeriod + 200ns);
  timer.shift_phase(-1us);
  EXPECT_EQ(timer.wait_next().grid, kFirst + 3 * kPeriod - 800ns);
  EXPECT_EQ(timer.phase_shift(), -800ns);
}

TEST(CycleTimer, ShiftsOfOneCycleAreLimitedToHalfAPeriod) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  EXPECT_EQ(timer.shift_phase(kPeriod), kPeriod / 2);
  EXPECT_EQ(timer.shift_phase(1ns), 0ns);
  EXPECT_EQ(timer.shift_phase(nanoseconds::max()), 0ns);
  EXPECT_EQ(timer.wait_next().grid, kFirst + kPeriod / 2);
  EXPECT_EQ(timer.shift_phase(nanoseconds::min()), -kPeriod / 2);
  EXPECT_EQ(timer.wait_next().grid, kFirst + kPeriod);
  EXPECT_EQ(timer.phase_shift(), 0ns);
}

TEST(CycleTimer, StartForgetsShiftsAndCounters) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod};
  timer.start(kFirst);
  timer.wait_next();
  clock.advance(5 * kPeriod);
  timer.wait_next();
  timer.shift_phase(10ns);
  timer.start(1s);
  EXPECT_EQ(timer.missed_total(), 0);
  EXPECT_EQ(timer.phase_shift(), 0ns);
  const CycleStart start = timer.wait_next();
  EXPECT_EQ(start.grid, 1s);
  EXPECT_EQ(start.cycle, 0);
}

TEST(CycleTimer, RandomWorkAndShiftsNeverLeaveTheGrid) {
  std::mt19937_64 random{20240817};
  std::uniform_int_distribution<std::int64_t> work_ns{0, 3 * kPeriod.count()};
  std::uniform_int_distribution<std::int64_t> shift_ns{-500, 500};
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod, 20us};
  timer.start(kFirst);
  std::int64_t cycles = 0;
  for (int i = 0; i < 20'000; ++i) {
    const CycleStart start = timer.wait_next();
    ASSERT_EQ(start.grid, kFirst + start.cycle * kPeriod + timer.phase_shift());
    ASSERT_GE(start.wake, start.grid);
    ASSERT_LT(start.wake - start.grid, kPeriod);
    ASSERT_EQ(start.cycle, cycles + start.missed);
    cycles = start.cycle + 1;
    clock.advance(nanoseconds{work_ns(random)});
    timer.shift_phase(nanoseconds{shift_ns(random)});
  }
  EXPECT_EQ(cycles, 20'000 + timer.missed_total());
}

TEST(CycleTimer, LeadWakesEarlyAndSpinsToTheGrid) {
  SleepyClock clock;
  clock.oversleep_by(18us);  // the wake-up of an idle virtual CPU
  CycleTimer timer{clock, kPeriod, 25us};
  timer.start(kFirst);
  for (int i = 0; i < 10; ++i) {
    const CycleStart start = timer.wait_next();
    EXPECT_EQ(start.missed, 0);
    EXPECT_GE(start.wake, start.grid);
    EXPECT_LT(start.wake, start.grid + 100ns) << "not later than one turn of the spin loop";
  }
}

TEST(CycleTimer, AnEarlyThreadRunsBeforeTheInstantAndIsNotLate) {
  SleepyClock clock;
  clock.oversleep_by(18us);
  CycleTimer timer{clock, kPeriod, 20us, 30us};
  timer.start(kFirst);
  for (int i = 0; i < 10; ++i) {
    const CycleStart start = timer.wait_next();
    EXPECT_EQ(start.cycle, i);
    EXPECT_EQ(start.grid, kFirst + i * kPeriod);
    EXPECT_GE(start.wake, start.grid - 30us);
    EXPECT_LT(start.wake, start.grid - 30us + 100ns) << "not later than one turn of the spin loop";
    EXPECT_EQ(start.late(kPeriod), 0ns);
    EXPECT_EQ(start.missed, 0);
  }
}

TEST(CycleTimer, AnEarlyThreadIsLateFromTheInstantOn) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod, 0ns, 30us};
  timer.start(kFirst);
  EXPECT_EQ(timer.wait_next().wake, kFirst - 30us);
  clock.sleep_until(kFirst + kPeriod - 10us);
  auto start = timer.wait_next();
  EXPECT_EQ(start.wake, kFirst + kPeriod - 10us) << "at once";
  EXPECT_EQ(start.late(kPeriod), 0ns);
  clock.sleep_until(kFirst + 2 * kPeriod + 10us);
  start = timer.wait_next();
  EXPECT_EQ(start.late(kPeriod), 10us);
  EXPECT_EQ(start.missed, 0);
  clock.sleep_until(kFirst + 5 * kPeriod - 10us);
  start = timer.wait_next();
  EXPECT_EQ(start.missed, 1) << "instant 4 is still in time, for 3 it is too late";
  EXPECT_EQ(start.cycle, 4);
  EXPECT_EQ(timer.wait_next().grid, kFirst + 5 * kPeriod);
}

TEST(CycleTimer, WhatIsDoneBetweenSleepAndInstantCostsNothing) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod, 20us};
  timer.start(kFirst);
  for (int i = 0; i < 10; ++i) {
    timer.sleep_ahead();
    EXPECT_EQ(clock.now(), kFirst + i * kPeriod - 20us);
    timer.sleep_ahead();
    EXPECT_EQ(clock.now(), kFirst + i * kPeriod - 20us) << "a second one does not sleep again";
    clock.advance(15us);
    const CycleStart start = timer.wait_next();
    EXPECT_EQ(start.cycle, i);
    EXPECT_EQ(start.wake, start.grid);
    EXPECT_EQ(start.grid, kFirst + i * kPeriod);
    clock.advance(40us);
  }
  timer.sleep_ahead();
  clock.advance(20us + kPeriod * 3 / 2);
  const CycleStart late = timer.wait_next();
  EXPECT_EQ(late.missed, 1);
  EXPECT_EQ(late.wake, late.grid + kPeriod / 2);
}

TEST(CycleTimer, AShiftBetweenSleepAndInstantIsOfTheInstantBehindIt) {
  VirtualClock clock;
  CycleTimer timer{clock, kPeriod, 20us};
  timer.start(kFirst);
  timer.sleep_ahead();
  timer.shift_phase(1us);
  EXPECT_EQ(timer.wait_next().grid, kFirst);
  EXPECT_EQ(timer.wait_next().grid, kFirst + kPeriod + 1us);
}

TEST(CycleTimer, LeadThatIsTooShortForTheWakeUpShowsAsLatency) {
  SleepyClock clock;
  clock.oversleep_by(40us);
  CycleTimer timer{clock, kPeriod, 25us};
  timer.start(kFirst);
  const CycleStart start = timer.wait_next();
  EXPECT_EQ(start.wake - start.grid, 15us);
}

TEST(CycleTimer, ValuesOutOfRangeAreRefused) {
  VirtualClock clock;
  EXPECT_THROW((CycleTimer{clock, 0ns}), std::invalid_argument);
  EXPECT_THROW((CycleTimer{clock, -1ns}), std::invalid_argument);
  EXPECT_THROW((CycleTimer{clock, kPeriod, -1ns}), std::invalid_argument);
  EXPECT_THROW((CycleTimer{clock, kPeriod, kPeriod / 4 + 1ns}), std::invalid_argument);
  EXPECT_THROW((CycleTimer{clock, kPeriod, 0ns, -1ns}), std::invalid_argument);
  EXPECT_THROW((CycleTimer{clock, kPeriod, 0ns, kPeriod / 4 + 1ns}), std::invalid_argument);
  EXPECT_NO_THROW((CycleTimer{clock, kPeriod, kPeriod / 4}));
}

/// Measures for how much of the time the owner of a clock sleeps.
class SleepMeter final : public Clock {
 public:
  [[nodiscard]] nanoseconds now() const noexcept override { return now_; }
  void sleep_until(nanoseconds deadline) noexcept override {
    if (now_ < deadline) {
      slept_ += deadline - now_;
      now_ = deadline;
    }
  }
  void spin() noexcept override { now_ += 500ns; }
  void work(nanoseconds time) { now_ += time; }
  [[nodiscard]] double awake_share() const {
    return 1.0 - static_cast<double>(slept_.count()) / static_cast<double>(now_.count());
  }

 private:
  nanoseconds now_{};
  nanoseconds slept_{};
};

class CycleTimerLoad : public testing::TestWithParam<double> {};

TEST_P(CycleTimerLoad, StaysBelowTheShareAtWhichLinuxThrottles) {
  SleepMeter clock;
  CycleTimer timer{clock, kPeriod, kPeriod / 4};
  timer.start(0ns);
  const auto work = std::chrono::duration_cast<nanoseconds>(GetParam() * kPeriod);
  for (int i = 0; i < 20'000; ++i) {
    timer.wait_next();
    clock.work(work);
  }
  EXPECT_LT(clock.awake_share(), 0.9425);
  EXPECT_GT(timer.forced_rests(), 0);
}

INSTANTIATE_TEST_SUITE_P(PeriodsOfWork, CycleTimerLoad,
                         testing::Values(0.75, 0.96, 0.999, 1.0, 1.001, 1.5, 2.0, 7.3, 100.0));

/// A stopped thread uses no CPU.
class StoppedClock final : public Clock {
 public:
  [[nodiscard]] nanoseconds now() const noexcept override { return now_; }
  void sleep_until(nanoseconds deadline) noexcept override { now_ = std::max(now_, deadline); }
  void spin() noexcept override { work(500ns); }
  [[nodiscard]] nanoseconds cpu_time() const noexcept override { return used_; }
  void work(nanoseconds time) noexcept {
    now_ += time;
    used_ += time;
  }
  void stop_for(nanoseconds time) noexcept { now_ += time; }

 private:
  nanoseconds now_{};
  nanoseconds used_{};
};

TEST(CycleTimer, TimeInWhichTheThreadWasStoppedOwesNoRest) {
  StoppedClock clock;
  CycleTimer timer{clock, kPeriod, kPeriod / 4};
  timer.start(0ns);
  for (int i = 0; i < 1'000; ++i) {
    timer.wait_next();
    clock.work(kPeriod * 65 / 100);
    if (i % 100 == 50) clock.stop_for(432 * kPeriod);
  }
  EXPECT_EQ(timer.forced_rests(), 0);
  EXPECT_EQ(timer.missed_total(), 10 * 431);  // it was stopped within a period
}

TEST(CycleTimer, OrdinaryLoadIsNeverForcedToRest) {
  SleepMeter clock;
  CycleTimer timer{clock, kPeriod, kPeriod / 4};
  timer.start(0ns);
  for (int i = 0; i < 20'000; ++i) {
    timer.wait_next();
    clock.work(kPeriod * 65 / 100);
  }
  EXPECT_EQ(timer.forced_rests(), 0);
  EXPECT_EQ(timer.missed_total(), 0);
}

}  // namespace
}  // namespace driveline::rt
