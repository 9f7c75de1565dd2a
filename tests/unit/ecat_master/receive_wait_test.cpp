// How a cycle waits for its answers, on a clock that counts the calls.
#include "driveline/ecat_master/cyclic/receive_wait.hpp"

#include <gtest/gtest.h>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "support/fake_port.hpp"

namespace driveline::ecat_master {
namespace {

using ecat_master_test::answered;
using ecat_master_test::FakePort;
using std::chrono::microseconds;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr auto kPeriod = 1ms;
constexpr auto kWindow = 750us;

/// A clock on which every sleep ends late.
class CountingClock final : public rt::Clock {
 public:
  explicit CountingClock(rt::VirtualClock& clock) : clock_(clock) {}

  [[nodiscard]] nanoseconds now() const noexcept override { return clock_.now(); }
  void sleep_until(nanoseconds deadline) noexcept override {
    ++sleeps;
    clock_.sleep_until(deadline + late);
  }
  void spin() noexcept override {
    ++turns;
    clock_.spin();
  }

  nanoseconds late{};
  int sleeps = 0;
  int turns = 0;

 private:
  rt::VirtualClock& clock_;
};

class ReceiveWaitTest : public testing::Test {
 protected:
  ReceiveWaitTest() {
    port.on_send = [this](std::span<const std::byte> frame) {
      if (returns_after > 0ns) port.arrive(answered(frame, std::byte{1}), returns_after);
    };
  }
  void make(ReceiveStrategy strategy) {
    ProcessDataDemand demand;
    demand.channels = {{true, 2, 0x1100, 4}, {false, 3, 0x1400, 4}};
    CyclicCore::Settings settings;
    settings.period = kPeriod;
    settings.receive_window = kWindow;
    settings.receive = strategy;
    core.emplace(port, counting, ProcessImage::lay_out({&demand, 1}).value(), nullptr, motion::SampleRings{}, settings);
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i, ++cycle) {
      time.sleep_until(kPeriod * cycle);
      core->cycle({cycle, time.now(), time.now(), 0});
      longest = std::max(longest, time.now() - kPeriod * cycle);
    }
  }
  /// Starts counting.
  void count() {
    core->count(false);
    run(1);
    core->count(true);
    counting.sleeps = counting.turns = 0;
    longest = {};
  }
  [[nodiscard]] const motion::CycleStatistics& seen() const { return core->statistics(); }

  rt::VirtualClock time;
  CountingClock counting{time};
  FakePort port{time};
  nanoseconds returns_after = 300us;
  std::optional<CyclicCore> core;
  std::int64_t cycle = 1;
  nanoseconds longest{};  ///< cycle
};

/// Counting that is switched off and on between two cycles starts anew.
TEST_F(ReceiveWaitTest, CountsAnewEvenIfNoCycleSawTheCountingEnd) {
  make(ReceiveStrategy::kSpin);
  run(20);
  ASSERT_EQ(seen().cycles, 20U);
  core->count(true);
  run(1);
  ASSERT_EQ(seen().cycles, 21U) << "it was on already";
  core->count(false);
  core->count(true);
  run(3);
  EXPECT_EQ(seen().cycles, 3U);
  core->count(true);
  core->count(false);
  run(2);
  EXPECT_EQ(seen().cycles, 3U) << "off";
}

TEST_F(ReceiveWaitTest, SleepsUntilShortlyBeforeItsAnswer) {
  make(ReceiveStrategy::kSleep);
  run(20);
  count();
  run(100);
  EXPECT_EQ(counting.sleeps, 100);
  EXPECT_LT(counting.turns, 100 * 45) << "300 without a sleep";
  EXPECT_LE(seen().round_trip.max(), 301us) << "it looks when the answer comes";
  EXPECT_EQ(seen().lost_frames, 0U);
}

TEST_F(ReceiveWaitTest, AnswersThatComeSoonAreNotSleptFor) {
  make(ReceiveStrategy::kSleep);
  returns_after = 59us;
  run(100);
  EXPECT_EQ(counting.sleeps, 0);
  EXPECT_EQ(seen().lost_frames, 0U);
}

TEST_F(ReceiveWaitTest, LearnsHowLateItWakes) {
  make(ReceiveStrategy::kSleep);
  counting.late = 70us;
  run(200);
  count();
  run(1000);
  EXPECT_EQ(counting.sleeps, 1000);
  EXPECT_LE(seen().round_trip.max(), 301us);
  counting.late = 2us;
  run(10'000);
  count();
  run(100);
  EXPECT_LT(counting.turns, 100 * 35) << "a machine that has become better";
  EXPECT_LE(seen().round_trip.max(), 301us);
}

TEST_F(ReceiveWaitTest, AnswersThatComeSoonerThanBeforeAreReadInTimeSoon) {
  make(ReceiveStrategy::kSleep);
  run(100);
  returns_after = 100us;
  run(10);
  EXPECT_EQ(seen().lost_frames, 0U);
  count();
  run(100);
  EXPECT_LE(seen().round_trip.max(), 101us);
}

TEST_F(ReceiveWaitTest, AnswersThatComeLaterThanBeforeAreWaitedFor) {
  make(ReceiveStrategy::kSleep);
  run(100);
  returns_after = 600us;
  run(100);
  EXPECT_EQ(seen().lost_frames, 0U);
  EXPECT_LE(seen().round_trip.max(), 602us);
}

TEST_F(ReceiveWaitTest, NoStrategyWaitsLongerThanItsWindowForAnAnswerThatIsLost) {
  for (const auto strategy : {ReceiveStrategy::kSpin, ReceiveStrategy::kSleep, ReceiveStrategy::kBlock}) {
    SCOPED_TRACE(static_cast<int>(strategy));
    returns_after = 300us;
    make(strategy);
    run(20);
    returns_after = 0ns;
    count();
    run(100);
    EXPECT_EQ(seen().lost_frames, 100U);
    EXPECT_LE(longest, kWindow + 3us);
    returns_after = 300us;
    count();
    run(100);
    EXPECT_EQ(seen().lost_frames, 0U);
    EXPECT_LE(seen().round_trip.max(), 302us);
  }
}

TEST_F(ReceiveWaitTest, LooksAgainAndAgainWhenToldTo) {
  make(ReceiveStrategy::kSpin);
  run(100);
  EXPECT_EQ(counting.sleeps, 0);
  EXPECT_GE(counting.turns, 100 * 290);
}

TEST_F(ReceiveWaitTest, SleepsInThePortWhenToldTo) {
  make(ReceiveStrategy::kBlock);
  int waits = 0;
  port.on_wait = [&waits] { ++waits; };
  run(100);
  EXPECT_EQ(waits, 100);
  EXPECT_EQ(counting.turns, 0);
  EXPECT_EQ(counting.sleeps, 0);
  EXPECT_EQ(seen().lost_frames, 0U);
  EXPECT_EQ(seen().round_trip.max(), 300us);
}

TEST(ReceiveWait, ALateWakeUpIsNoEarlyAnswer) {
  ReceiveWait wait{kWindow};
  EXPECT_FALSE(wait.wake_at(0ns)) << "nothing is known";
  wait.returned(400us);
  const auto before = wait.wake_at(0ns);
  ASSERT_TRUE(before);
  EXPECT_LT(*before, 400us);
  wait.were_there(500us);
  EXPECT_EQ(wait.wake_at(0ns), before);
  wait.were_there(320us);
  EXPECT_EQ(wait.wake_at(0ns), *before - 120us);
}

}  // namespace
}  // namespace driveline::ecat_master
