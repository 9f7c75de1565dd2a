#include "driveline/rt/clock.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <signal.h>

#include <atomic>
#include <thread>

namespace driveline::rt {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

TEST(MonotonicClock, AgreesWithTheStandardClock) {
  const MonotonicClock clock;
  // libstdc++ documents steady_clock as CLOCK_MONOTONIC.
  const nanoseconds before = std::chrono::steady_clock::now().time_since_epoch();
  const nanoseconds now = clock.now();
  const nanoseconds after = std::chrono::steady_clock::now().time_since_epoch();
  EXPECT_LE(before, now);
  EXPECT_LE(now, after);
}

TEST(MonotonicClock, NeverWakesEarly) {
  MonotonicClock clock;
  for (const nanoseconds ahead : {1ns, 1'000ns, 125'000ns, 1'000'000ns}) {
    const nanoseconds deadline = clock.now() + ahead;
    clock.sleep_until(deadline);
    EXPECT_GE(clock.now(), deadline);
  }
}

TEST(MonotonicClock, DeadlineInThePastReturns) {
  MonotonicClock clock;
  clock.sleep_until(nanoseconds::min());
  clock.sleep_until(-1ns);
  clock.sleep_until(0ns);
  clock.sleep_until(clock.now() - 1s);
}

std::atomic<int> g_signals{0};

TEST(MonotonicClock, SignalsDoNotShortenTheSleep) {
  struct sigaction action {};
  action.sa_handler = [](int) { g_signals.fetch_add(1); };  // no SA_RESTART: the sleep is interrupted
  struct sigaction previous {};
  ASSERT_EQ(sigaction(SIGUSR1, &action, &previous), 0);
  g_signals = 0;

  std::atomic<bool> asleep_or_about{false};
  std::atomic<bool> done{false};
  bool early = false;
  std::thread sleeper{[&] {
    MonotonicClock clock;
    const nanoseconds deadline = clock.now() + 100ms;
    asleep_or_about = true;
    clock.sleep_until(deadline);
    early = clock.now() < deadline;
    done = true;
  }};
  while (!asleep_or_about) {
    std::this_thread::yield();
  }
  while (!done && g_signals < 5) {
    pthread_kill(sleeper.native_handle(), SIGUSR1);
    std::this_thread::sleep_for(1ms);
  }
  sleeper.join();
  sigaction(SIGUSR1, &previous, nullptr);
  EXPECT_FALSE(early);
  EXPECT_GE(g_signals.load(), 1);
}

TEST(MonotonicClock, SpinsUntilTheInstantAndNoTimeForOneThatHasPassed) {
  MonotonicClock clock;
  for (const auto ahead : {200ns, 5000ns}) {
    const auto instant = clock.now() + ahead;
    const auto seen = clock.spin_until(instant);
    EXPECT_GE(seen, instant);
    EXPECT_LE(seen, clock.now());
  }
  EXPECT_GE(clock.spin_until(nanoseconds::min()), 0ns);
}

TEST(VirtualClock, SpinsUntilAnInstantInItsSteps) {
  VirtualClock clock{0ns, 20ns};
  EXPECT_EQ(clock.spin_until(50ns), 60ns);
  EXPECT_EQ(clock.spin_until(50ns), 60ns);
}

TEST(VirtualClock, MovesOnlyWhenTold) {
  VirtualClock clock{5ns, 20ns};
  EXPECT_EQ(clock.now(), 5ns);
  EXPECT_EQ(clock.now(), 5ns);
  clock.advance(3ns);
  EXPECT_EQ(clock.now(), 8ns);
  clock.spin();
  EXPECT_EQ(clock.now(), 28ns);
  clock.sleep_until(1s);
  EXPECT_EQ(clock.now(), 1s);
}

TEST(VirtualClock, NeverMovesBack) {
  VirtualClock clock{100ns};
  clock.sleep_until(40ns);
  EXPECT_EQ(clock.now(), 100ns);
  clock.advance(-50ns);
  EXPECT_EQ(clock.now(), 100ns);
}

TEST(VirtualClock, ReaderOfATimeSeesWhatWasWrittenBefore) {
  VirtualClock clock;
  int written = 0;  // deliberately not atomic: ordered by the clock alone
  std::thread reader{[&] {
    while (clock.now() < 10ns) {
      std::this_thread::yield();
    }
    EXPECT_EQ(written, 42);
  }};
  written = 42;
  clock.sleep_until(10ns);
  reader.join();
}

TEST(VirtualClock, AdvancedByTwoThreadsLosesNothing) {
  VirtualClock clock;
  const auto walk = [&clock] {
    for (int i = 0; i < 10'000; ++i) {
      clock.advance(1ns);
    }
  };
  std::thread other{walk};
  walk();
  other.join();
  EXPECT_EQ(clock.now(), 20'000ns);
}

}  // namespace
}  // namespace driveline::rt
