// Datagrams that the cycle sends and its reaction to the answers, one at a time.
#include "driveline/ecat_master/dc/clock_follower.hpp"

#include <gtest/gtest.h>

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::microseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr std::uint16_t kStation = 0x1003;
constexpr nanoseconds kPeriod = microseconds{125};

/// Reference clock at 5 s when the master's clock shows 1 s; SYNC0 on multiples of the period; two followers.
LineClocks some_clocks() {
  LineClocks clocks;
  clocks.period = kPeriod;
  clocks.frame_lead = microseconds{50};
  clocks.reference = 1;
  clocks.station = kStation;
  clocks.slaves.resize(4);
  for (const std::size_t i : {1U, 2U, 3U}) clocks.slaves[i].present = true;
  for (const std::size_t i : {2U, 3U}) clocks.slaves[i].follows = true;
  clocks.mapping = {seconds{1}, 5'000'000'000U, 0.0};
  clocks.start = 5'000'000'000U;
  clocks.common_cycle = kPeriod;
  return clocks;
}

rt::CycleStart start_at(nanoseconds grid) {
  return {0, grid, grid, 0};
}

TEST(ClockFollower, FirstGridInstantHasThePlannedPhase) {
  const ClockFollower follower(some_clocks());
  // 1 s is a SYNC0; frames pass 50 us before one.
  EXPECT_EQ(follower.first_grid(seconds{1}), seconds{1} + microseconds{75});
  EXPECT_EQ(follower.first_grid(seconds{1} + microseconds{75}), seconds{1} + microseconds{75});
  EXPECT_EQ(follower.first_grid(seconds{1} + microseconds{75} + nanoseconds{1}), seconds{1} + microseconds{200});
}

TEST(ClockFollower, SendsTheTimeThatIsExpectedOfTheReferenceClock) {
  ClockFollower follower(some_clocks());
  const auto drift = follower.next(seconds{1} + microseconds{75});
  EXPECT_EQ(drift.command, wire::Command::kFrmw);
  EXPECT_EQ(drift.address, wire::DatagramAddress::physical(kStation, 0x0910));
  EXPECT_NEAR(drift.time, static_cast<std::uint32_t>(5'000'075'000U), 1.0);
}

TEST(ClockFollower, LateFramesAreSentEarlierWhateverTheWakeUpDid) {
  for (const auto latency : {nanoseconds{0}, nanoseconds{40'000}}) {
    ClockFollower follower(some_clocks());
    const auto grid = follower.first_grid(seconds{1});
    const auto sent = follower.next(grid + latency);
    // The reference clock is 800 ns ahead of the expected time: the frame was late.
    const DriftAnswer answer{sent.time + 800, 3};
    EXPECT_LT(follower.finish(start_at(grid), grid + latency, answer), nanoseconds{0}) << latency.count();
    EXPECT_EQ(follower.finish(start_at(grid), grid + latency, std::nullopt), nanoseconds{0}) << "coasts";
  }
}

/// A time that the test sets.
class SettableTime final : public TimeSource {
 public:
  nanoseconds time{0};
  [[nodiscard]] nanoseconds now() const noexcept override { return time; }
};

TEST(ClockFollower, NoJumpOfTheTimeItFollowsIsTooFar) {
  SettableTime time;
  auto clocks = some_clocks();
  clocks.mode = FollowMode::kReferenceFollows;
  clocks.time = &time;
  ClockFollower follower(clocks);
  const auto grid = follower.first_grid(seconds{1});
  std::uint64_t jumps = 0;
  for (int cycle = 0; cycle < 40; ++cycle) {
    const auto now = grid + cycle * kPeriod;
    // Set in every second cycle; every fifth time is another one.
    const nanoseconds starts[] = {seconds{0}, nanoseconds::max() - seconds{1}, nanoseconds::min(), seconds{7}};
    time.time = wrapped_sum(starts[cycle / 10], now);
    if (cycle > 0 && cycle % 10 == 0) ++jumps;
    const auto sent = follower.next(now);
    if (sent.command == wire::Command::kFpwr) {
      EXPECT_EQ(sent.time, static_cast<std::uint32_t>(now.count())) << cycle << ": as if it had not jumped";
    }
    static_cast<void>(follower.finish(start_at(now), now, DriftAnswer{sent.time, 3}));
  }
  EXPECT_EQ(follower.status().time_jumps, jumps);
}

TEST(ClockFollower, WhateverTheReferenceClockAnswersTheGridMovesALittleAtMost) {
  for (const std::uint64_t start : {std::uint64_t{0}, (std::uint64_t{1} << 63) - 1, ~std::uint64_t{0}}) {
    auto clocks = some_clocks();
    clocks.start = start;
    ClockFollower follower(clocks);
    auto grid = follower.first_grid(seconds{1});
    std::uint32_t answer = 1;
    for (int cycle = 0; cycle < 2000; ++cycle) {
      const auto sent = follower.next(grid);
      answer = answer * 1'664'525U + 1'013'904'223U;
      const std::uint32_t times[] = {answer, sent.time + 0x7FFF'FFFFU, sent.time + 0x8000'0000U, 0, ~0U};
      const auto shift = follower.finish(start_at(grid), grid + nanoseconds{answer % 1'000'000},
                                         DriftAnswer{times[cycle % 5], static_cast<std::uint16_t>(answer >> 16)});
      ASSERT_LE(std::chrono::abs(shift), kPeriod / 100);
      grid += kPeriod + shift;
    }
  }
}

TEST(ClockFollower, AnAnswerNobodyHasReadIsNone) {
  ClockFollower follower(some_clocks());
  const auto grid = follower.first_grid(seconds{1});
  auto sent = follower.next(grid);
  // Returned as it was sent, with a working counter that is one short: the other slaves have written it, the reference
  // clock was missing.
  static_cast<void>(follower.finish(start_at(grid), grid, DriftAnswer{sent.time, 2}));
  EXPECT_EQ(follower.status().silent, 1U);
  // From then on the time is only read, so that the other clocks do not get guesses.
  sent = follower.next(grid + kPeriod);
  EXPECT_EQ(sent.command, wire::Command::kFprd);
  static_cast<void>(follower.finish(start_at(grid + kPeriod), grid + kPeriod, DriftAnswer{sent.time, 0}));
  EXPECT_EQ(follower.status().silent, 2U);
  sent = follower.next(grid + 2 * kPeriod);
  static_cast<void>(follower.finish(start_at(grid + 2 * kPeriod), grid + 2 * kPeriod, DriftAnswer{sent.time, 1}));
  EXPECT_EQ(follower.status().silent, 0U);
  EXPECT_EQ(follower.next(grid + 3 * kPeriod).command, wire::Command::kFrmw);
}

/// A reference clock with exactly the expected time must not be taken for a silent one.
TEST(ClockFollower, APerfectReferenceClockIsNotTakenForASilentOne) {
  ClockFollower follower(some_clocks());
  auto grid = follower.first_grid(seconds{1});
  for (int i = 0; i < 100; ++i) {
    static_cast<void>(follower.next(grid));
    const ClockMapping truth{seconds{1}, 5'000'000'000U, 0.0};
    const auto shift =
        follower.finish(start_at(grid), grid, DriftAnswer{static_cast<std::uint32_t>(truth.at(grid)), 2});
    EXPECT_LE(follower.status().silent, 1U) << i;
    grid += kPeriod + shift;
  }
}

/// A reference clock that is set to the master's time has it to the nanosecond. A frame that returns with exactly the
/// sent time would look unanswered if another slave is missing as well.
TEST(ClockFollower, APerfectReferenceClockInBusShiftNeverLooksSilent) {
  auto clocks = some_clocks();
  clocks.mode = FollowMode::kReferenceFollows;
  ClockFollower follower(clocks);
  auto grid = follower.first_grid(seconds{1});
  for (int i = 0; i < 200; ++i, grid += kPeriod) {
    static_cast<void>(follower.next(grid));
    const ClockMapping truth{seconds{1}, 5'000'000'000U, 0.0};
    static_cast<void>(
        follower.finish(start_at(grid), grid, DriftAnswer{static_cast<std::uint32_t>(truth.at(grid)), 2}));
    ASSERT_EQ(follower.status().silent, 0U) << i;
  }
}

/// The sent time is that of the frame's arrival at the reference clock, even if frames leave some microseconds after
/// the clock was read for them.
TEST(ClockFollower, LearnsHowLongAfterTheReadingFramesLeave) {
  constexpr nanoseconds kWayOut{5000};
  ClockFollower follower(some_clocks());
  const ClockMapping truth{seconds{1}, 5'000'000'000U, 0.0};
  auto grid = follower.first_grid(seconds{1}) - kWayOut;
  std::int32_t off = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto sent = follower.next(grid);
    const auto met = static_cast<std::uint32_t>(truth.at(grid + kWayOut));
    off = static_cast<std::int32_t>(sent.time - met);
    grid += kPeriod + follower.finish(start_at(grid), grid + kWayOut, DriftAnswer{met, 3});
  }
  EXPECT_NEAR(off, 0, 20);
}

TEST(ClockFollower, LostFramesSayNothingAboutTheReferenceClock) {
  ClockFollower follower(some_clocks());
  auto grid = follower.first_grid(seconds{1});
  for (int i = 0; i < 50; ++i, grid += kPeriod) {
    static_cast<void>(follower.next(grid));
    static_cast<void>(follower.finish(start_at(grid), grid, std::nullopt));
  }
  EXPECT_EQ(follower.status().silent, 0U);
}

TEST(ClockFollower, WithoutReferenceTheDatagramDoesNothing) {
  ClockFollower follower(some_clocks());
  follower.set_reference({});
  EXPECT_EQ(follower.next(seconds{2}).command, wire::Command::kNop);
}

TEST(ClockFollower, AnotherReferenceBehindTheFirstKeepsThePhase) {
  ClockFollower follower(some_clocks());
  follower.set_reference({0x1005, 2000, 2});
  const auto grid = follower.first_grid(seconds{1});
  const auto sent = follower.next(grid);
  EXPECT_EQ(sent.address.adp(), 0x1005);
  const std::uint64_t on_time = 5'000'075'000U + 2000;  // it arrives two microseconds later
  EXPECT_NEAR(sent.time, static_cast<std::uint32_t>(on_time), 1.0);
  const auto shift = follower.finish(start_at(grid), grid, DriftAnswer{static_cast<std::uint32_t>(on_time), 2});
  EXPECT_EQ(shift, nanoseconds{0});
}

TEST(ClockFollower, BusShiftTellsTheReferenceEverySecondCycle) {
  auto clocks = some_clocks();
  clocks.mode = FollowMode::kReferenceFollows;
  ClockFollower follower(clocks);
  auto grid = follower.first_grid(seconds{1});
  for (int i = 0; i < 10; ++i, grid += kPeriod) {
    const auto sent = follower.next(grid);
    EXPECT_EQ(sent.command, i % 2 == 0 ? wire::Command::kFpwr : wire::Command::kFrmw);
    EXPECT_EQ(follower.finish(start_at(grid), grid, DriftAnswer{sent.time + 700, 3}), nanoseconds{0}) << "stands";
  }
}

}  // namespace
}  // namespace driveline::ecat_master::dc
