#include "driveline/ecat_master/dc/sync_signals.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr auto kBase = microseconds{125};

SyncSignals sync0(nanoseconds cycle, nanoseconds shift = {}) {
  return {kActivateSync0, cycle, shift, {}, {}};
}

SyncSignals both(nanoseconds cycle, nanoseconds sync1_cycle, nanoseconds sync1_shift) {
  return {0x0700, cycle, {}, sync1_cycle, sync1_shift};
}

std::string refusal(const SyncSignals& signals, nanoseconds period = microseconds{250}, nanoseconds base = kBase) {
  const auto checked = check_signals(signals, period, base, 3);
  return checked ? std::string{} : describe(checked.error());
}

TEST(SyncSignals, UsualSettingsAreAccepted) {
  EXPECT_EQ(refusal(sync0(microseconds{250})), "");
  EXPECT_EQ(refusal(sync0(microseconds{125})), "");
  EXPECT_EQ(refusal(sync0(milliseconds{1}, microseconds{-300})), "");
  EXPECT_EQ(refusal(both(microseconds{125}, microseconds{250}, microseconds{30})), "");
  EXPECT_EQ(refusal(both(microseconds{250}, {}, microseconds{249})), "");
  EXPECT_EQ(refusal(SyncSignals{}), "") << "no signals at all";
  EXPECT_EQ(refusal(sync0(microseconds{100}), microseconds{100}, nanoseconds{0}), "") << "no time base";
}

TEST(SyncSignals, EachRuleHasItsSentence) {
  EXPECT_EQ(refusal(sync0(microseconds{200}), microseconds{400}),
            "slave 3: the SYNC0 cycle of 200000 ns is not a multiple of 125000 ns");
  EXPECT_EQ(refusal(sync0(microseconds{375})),
            "slave 3: SYNC0 cycle of 375000 ns and cycle time of 250000 ns are not multiples of each other");
  EXPECT_EQ(refusal(sync0(nanoseconds{0})), "slave 3: a SYNC0 cycle of 0 ns is outside 1 .. 4294967295 ns");
  EXPECT_EQ(refusal(sync0(seconds{5})), "slave 3: a SYNC0 cycle of 4294967295 ns is outside 1 .. 4294967295 ns");
  EXPECT_EQ(refusal(sync0(microseconds{250}, microseconds{250})),
            "slave 3: the SYNC0 shift of 250000 ns is not shorter than the SYNC0 cycle of 250000 ns");
  EXPECT_EQ(refusal(sync0(microseconds{250}, microseconds{-250})),
            "slave 3: the SYNC0 shift of -250000 ns is not shorter than the SYNC0 cycle of 250000 ns");
  EXPECT_EQ(refusal(SyncSignals{0x0500, microseconds{250}, {}, {}, {}}),
            "slave 3: SYNC1 is activated without SYNC0, which starts it (assign/activate 0x0500)");
  EXPECT_EQ(refusal(both(microseconds{250}, microseconds{375}, {})),
            "slave 3: the SYNC1 cycle of 375000 ns is not a multiple of the SYNC0 cycle of 250000 ns");
  EXPECT_EQ(refusal(both(microseconds{250}, {}, microseconds{250})),
            "slave 3: the SYNC1 shift of 250000 ns is not between 0 and the SYNC0 cycle of 250000 ns");
  EXPECT_EQ(refusal(both(microseconds{250}, {}, microseconds{-1})),
            "slave 3: the SYNC1 shift of -1000 ns is not between 0 and the SYNC0 cycle of 250000 ns");
}

TEST(SyncSignals, Sync1RegisterHoldsCycleAndShift) {
  EXPECT_EQ(both(microseconds{250}, {}, {}).sync1_register(), nanoseconds{0}) << "together with SYNC0";
  EXPECT_EQ(both(microseconds{250}, {}, microseconds{40}).sync1_register(), microseconds{40});
  EXPECT_EQ(both(microseconds{250}, microseconds{250}, microseconds{40}).sync1_register(), microseconds{40});
  EXPECT_EQ(both(microseconds{250}, microseconds{500}, {}).sync1_register(), microseconds{250});
  EXPECT_EQ(both(microseconds{125}, microseconds{1000}, microseconds{20}).sync1_register(), microseconds{895});
}

TEST(SyncSignals, ComeFromAnOperationMode) {
  esi::DcOpMode mode;
  mode.assign_activate = 0x0300;
  EXPECT_EQ(from_op_mode(mode, milliseconds{1}), sync0(milliseconds{1}));
  mode.cycle_time_sync0_factor = -4;
  mode.shift_time_sync0_ns = 1000;
  EXPECT_EQ(from_op_mode(mode, milliseconds{1}), sync0(microseconds{250}, microseconds{1}));
  mode.assign_activate = 0x0700;
  mode.cycle_time_sync1_factor = 4;
  mode.shift_time_sync1_ns = 500;
  const auto signals = from_op_mode(mode, milliseconds{1});
  EXPECT_EQ(signals.sync1_cycle, milliseconds{1});
  EXPECT_EQ(signals.sync1_shift, nanoseconds{500});
  mode.cycle_time_sync0_ns = 500'000;
  EXPECT_EQ(from_op_mode(mode, milliseconds{1}).sync0_cycle, microseconds{500});
  mode.assign_activate = 0;
  EXPECT_FALSE(from_op_mode(mode, milliseconds{1}).active());
}

TEST(StartTime, IsTheSamePhaseForEveryCombinationOfCycles) {
  const std::vector<SyncSignals> slaves = {sync0(microseconds{250}), sync0(microseconds{375}, microseconds{20}),
                                           both(microseconds{125}, milliseconds{1}, {}), SyncSignals{}};
  const auto common = common_cycle(slaves, microseconds{125});
  ASSERT_TRUE(common);
  EXPECT_EQ(*common, milliseconds{3});
}

TEST(StartTime, CyclesThatHardlyEverMeetAreRefused) {
  const std::vector<SyncSignals> slaves = {sync0(microseconds{250}), sync0(nanoseconds{125'001})};
  const auto common = common_cycle(slaves, microseconds{125});
  ASSERT_FALSE(common);
  EXPECT_EQ(describe(common.error()),
            "slave 1: its cycle of 125001 ns and those of the others have a common period of more than 4 s");
}

TEST(StartTimeProperty, LiesInTheFutureOnTheGridAndNotFurtherThanNeeded) {
  EXPECT_TRUE(rc::check([] {
    const auto now = *rc::gen::arbitrary<std::uint64_t>() >> 1;
    const auto lead = nanoseconds{*rc::gen::inRange<std::int64_t>(0, 2'000'000'000)};
    const auto common = nanoseconds{*rc::gen::inRange<std::int64_t>(1, 4'000'000'000)};
    const auto start = start_time(now, lead, common);
    RC_ASSERT(start % static_cast<std::uint64_t>(common.count()) == 0U);
    RC_ASSERT(start - now >= static_cast<std::uint64_t>(lead.count()));
    RC_ASSERT(start - now < static_cast<std::uint64_t>((lead + common).count()));
  }));
}

TEST(SyncSignals, CyclesThatRepeatTogetherInSomeCenturiesAreRefused) {
  // Primes: their product is more than 64 bits of nanoseconds hold.
  const std::array signals{sync0(nanoseconds{3'999'999'979}), sync0(nanoseconds{4'294'967'291})};
  const auto common = common_cycle(signals, nanoseconds{1});
  ASSERT_FALSE(common);
  EXPECT_EQ(describe(common.error()),
            "slave 1: its cycle of 4294967291 ns and those of the others have a common period of more than 4 s");
}

TEST(SyncSignals, FactorsOfADescriptionDoNotOverflow) {
  esi::DcOpMode mode;
  mode.assign_activate = 0x0700;
  mode.cycle_time_sync0_factor = 32'767;
  mode.cycle_time_sync1_factor = 32'767;
  EXPECT_EQ(refusal(from_op_mode(mode, seconds{10}), seconds{10}, nanoseconds{0}),
            "slave 3: a SYNC0 cycle of 4294967295 ns is outside 1 .. 4294967295 ns");
}

TEST(SyncSignals, TheStartTimeIsAheadAlsoWhereTheClockBeginsAgain) {
  const auto now = ~std::uint64_t{0} - 1'000;
  const auto start = start_time(now, milliseconds{1}, milliseconds{2});
  EXPECT_GE(start - now, 1'000'000U);
  EXPECT_LE(start - now, 3'000'000U);
}

}  // namespace
}  // namespace driveline::ecat_master::dc
