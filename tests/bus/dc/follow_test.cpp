// The master's cycle and the reference clock, from lock to loss, seen from outside on virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clock_run.hpp"
#include "true_time.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::FollowMode;
using slaves::LineOptions;
using slaves::MasterPort;
using slaves::Wiring;

LineOptions with_cable(nanoseconds cable) {
  LineOptions options;
  options.cable_delay = cable;
  return options;
}

/// Largest phase error of the frames over `duration`, as they truly arrived at the reference clock.
nanoseconds worst_arrival(ClockRun& run, nanoseconds duration) {
  nanoseconds worst{0};
  run.run(duration, [&] { worst = std::max(worst, std::chrono::abs(run.arrival_error())); });
  return worst;
}

TEST(ClockFollowing, TheCycleLocksAndHoldsItsPhase) {
  for (const auto period :
       {microseconds{125}, microseconds{250}, microseconds{1000}, microseconds{4000}, microseconds{10'000}}) {
    for (const double ppm : {-100.0, 3.0, 100.0}) {
      auto specs = random_clocks(3, 0.0);
      for (auto& spec : specs) spec.ppm = ppm;
      ClockLine line(specs, std::nullopt, with_cable(nanoseconds{50}));
      ClockRun run(line);
      ASSERT_EQ(run.start(line.plan(period)), "") << period.count() << " us, " << ppm << " ppm";
      run.run(seconds{2});
      EXPECT_LE(worst_arrival(run, seconds{1}), nanoseconds{20}) << period.count() << " us, " << ppm << " ppm";
      EXPECT_TRUE(run.status().locked);
      EXPECT_NEAR(run.status().ppm, ppm, 0.5) << period.count() << " us";
    }
  }
}

/// The system time of one slave runs at the speed of its own oscillator; the others, each with an oscillator of another
/// speed, run at the speed of that one.
TEST(ClockFollowing, OneClockIsTheReferenceThatTheOthersFollow) {
  for (const std::uint16_t chosen : {std::uint16_t{0}, std::uint16_t{2}}) {
    auto specs = random_clocks(5, 0.0);
    for (std::size_t i = 0; i < specs.size(); ++i) specs[i].ppm = 37.0 * static_cast<double>(i) - 61.0;
    ClockLine line(specs);
    ClockRun run(line);
    auto plan = line.plan();
    plan.reference = chosen;
    for (std::size_t i = 0; i < chosen; ++i) plan.slaves[i].signals = {};  // frames pass them before the reference
    ASSERT_EQ(run.start(plan), "");
    EXPECT_EQ(run.clocks().reference, chosen);
    run.run(seconds{2});
    const auto begin = line.clock.now();
    std::vector<std::uint64_t> before;
    for (std::size_t i = 0; i < specs.size(); ++i) before.push_back(line.system_time(i));
    run.run(seconds{1});
    const auto passed_ns = static_cast<double>((line.clock.now() - begin).count());
    for (std::size_t i = chosen; i < specs.size(); ++i) {
      const auto counted_ns = static_cast<double>(ahead_of(line.system_time(i), before[i]).count());
      EXPECT_NEAR((counted_ns / passed_ns - 1.0) * 1e6, specs[chosen].ppm, 0.2) << "ppm, slave " << i;
    }
  }
}

TEST(ClockFollowing, LocksWithinASecondAt125Microseconds) {
  ClockLine line(random_clocks(8, 100.0), std::nullopt, with_cable(nanoseconds{50}));
  ClockRun run(line);
  ASSERT_EQ(run.start(line.plan()), "");
  EXPECT_LT(run.cycles() * microseconds{125}, seconds{1}) << "first cycle to OP, lock included";
}

/// The process image is empty: there is no slave to judge, and nothing to judge it by.
TEST(ClockFollowing, LocksInPreOpWithoutProcessData) {
  ClockLine line(random_clocks(8, 100.0), std::nullopt, with_cable(nanoseconds{50}));
  ClockRun::Options options;
  options.process_data = false;
  ClockRun run(line, options);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{2});
  EXPECT_TRUE(run.status().locked);
  EXPECT_EQ(run.master().al_status()->front().status.state, wire::AlState::kPreOp);
}

/// Whenever the line starts, and whatever the clocks show, frames pass the reference clock at the planned phase, the
/// first one within a microsecond.
TEST(ClockFollowing, ThePhaseIsTheSameAtEveryStart) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    for (const auto lead : {microseconds{0}, microseconds{30}, microseconds{100}}) {
      ClockLine line(random_clocks(3, 100.0, seed), std::nullopt, with_cable(nanoseconds{50}),
                     nanoseconds{seed * 1'234'567'891LL});
      ClockRun run(line);
      auto plan = line.plan();
      plan.frame_lead = lead;
      nanoseconds first{0};
      bool any = false;
      ASSERT_EQ(run.start(plan), "");
      run.run(milliseconds{1}, [&] {
        if (!any) first = run.arrival_error();
        any = true;
      });
      EXPECT_LE(std::chrono::abs(first), microseconds{1}) << seed;
      run.run(milliseconds{500});
      EXPECT_LE(worst_arrival(run, milliseconds{200}), nanoseconds{20}) << seed << ", lead " << lead.count();
    }
  }
}

/// Late wake-ups delay frames, but do not move the grid: the controller does not see them.
TEST(ClockFollowing, LateWakeUpsDoNotMoveTheGrid) {
  std::mt19937 random(7);
  std::exponential_distribution<double> latency(1.0 / 8000.0);
  ClockLine line(random_clocks(3, 100.0), std::nullopt, with_cable(nanoseconds{50}));
  ClockRun::Options options;
  options.latency = [&] { return nanoseconds{std::min<std::int64_t>(60'000, std::llround(latency(random)))}; };
  ClockRun run(line, options);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{1});
  nanoseconds worst_grid{0};
  nanoseconds worst_frame{0};
  run.run(seconds{2}, [&] {
    worst_grid = std::max(worst_grid, std::chrono::abs(run.grid_error()));
    worst_frame = std::max(worst_frame, std::chrono::abs(run.arrival_error()));
  });
  EXPECT_GT(worst_frame, microseconds{30}) << "the test has no wake-up latency";
  EXPECT_LE(worst_grid, nanoseconds{30});
  EXPECT_TRUE(run.status().locked);
}

/// With launch times late wake-ups do not delay frames either, up to the lead of the cycle.
TEST(ClockFollowing, FramesThatAreHeldBackMeetTheReferenceClockInTime) {
  constexpr auto kEarly = microseconds{30};
  for (const bool held : {false, true}) {
    std::mt19937 random(7);
    std::uniform_int_distribution<std::int64_t> latency(0, nanoseconds{kEarly}.count());
    ClockLine line(random_clocks(3, 100.0), std::nullopt, with_cable(nanoseconds{50}));
    HoldingPort holding(line.line(), line.clock);
    ClockRun::Options options;
    options.latency = [&] { return nanoseconds{latency(random)}; };
    if (held) {
      options.port = &holding;
      options.early = kEarly;
    }
    ClockRun run(line, options);
    ASSERT_EQ(run.start(line.plan()), "");
    run.run(seconds{1});
    const auto worst = worst_arrival(run, seconds{2});
    if (held) {
      EXPECT_LE(worst, nanoseconds{30});
      EXPECT_GT(holding.earliest(), microseconds{29}) << "no frame was handed over early";
      EXPECT_EQ(run.master().core()->statistics().missed_periods, 0U);
    } else {
      EXPECT_GT(worst, microseconds{29}) << "the test has no wake-up latency";
    }
    EXPECT_TRUE(run.status().locked);
  }
}

TEST(ClockFollowing, LostFramesAreBridged) {
  ClockLine line(random_clocks(4, 100.0), std::nullopt, with_cable(nanoseconds{50}));
  Chance lost(100, 3);
  LossyPort lossy(line.line(), LossyPort::Direction::kOut, [&](auto, auto) { return lost(); });
  ClockRun::Options options;
  options.port = &lossy;
  ClockRun run(line, options);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{1});
  EXPECT_LE(worst_arrival(run, seconds{2}), nanoseconds{30});
  EXPECT_GT(lossy.lost(), 100U);
  EXPECT_TRUE(run.status().locked);
  EXPECT_EQ(run.status().unlocks, 0U);
}

TEST(ClockFollowing, A32BitReferenceClockWrapsUnnoticed) {
  auto specs = random_clocks(4, 80.0);
  for (auto& spec : specs) spec.wide = false;
  // The system time passes 2^32 ns a second after the start.
  ClockLine line(specs, std::nullopt, with_cable(nanoseconds{50}), nanoseconds{0x3'0000'0000} - seconds{1});
  ClockRun run(line);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(milliseconds{400});
  EXPECT_LE(worst_arrival(run, seconds{6}), nanoseconds{30});
  EXPECT_EQ(run.status().unlocks, 0U);
}

TEST(ClockFollowing, AddsNoFrame) {
  ClockLine with(random_clocks(3, 10.0));
  ClockRun run(with);
  ASSERT_EQ(run.start(with.plan()), "");
  const auto before = run.frames();
  const auto cycles = run.cycles();
  for (int i = 0; i < 100; ++i) run.cycle();
  EXPECT_EQ(run.frames() - before, run.cycles() - cycles);
}

TEST(ClockFollowing, BusShiftLeavesTheGridAndMovesTheReference) {
  auto specs = random_clocks(4, 100.0);
  specs[0].ppm = 90.0;
  ClockLine line(specs, std::nullopt, with_cable(nanoseconds{50}));
  ClockRun run(line);
  auto plan = line.plan();
  plan.mode = FollowMode::kReferenceFollows;
  ASSERT_EQ(run.start(plan), "");
  const auto phase = run.grid() % microseconds{125};
  run.run(seconds{1});
  nanoseconds worst{0};
  run.run(seconds{1}, [&] {
    EXPECT_EQ(run.grid() % microseconds{125}, phase);
    worst = std::max(worst, std::chrono::abs(run.arrival_error()));
  });
  EXPECT_LE(worst, microseconds{1});
  EXPECT_TRUE(run.status().locked);
}

TEST(ClockFollowing, AReferenceThatCannotBeFollowedIsNamed) {
  auto specs = random_clocks(2, 0.0);
  specs[0].ppm = 800.0;
  ClockLine line(specs);
  ClockRun run(line);
  EXPECT_EQ(run.start(line.plan()),
            "the cycle is not locked to the reference clock: it runs more than 500 ppm off the master's clock and "
            "cannot be disciplined");
}

/// A hub without a clock; the reference clock alone on one branch, three clocks on the other.
Wiring reference_on_a_branch() {
  Wiring wiring(5);
  EXPECT_TRUE(wiring.connect_master(MasterPort::kPrimary, {0, 0}, nanoseconds{20}));
  EXPECT_TRUE(wiring.connect({0, 3}, {1, 0}, nanoseconds{500}));
  EXPECT_TRUE(wiring.connect({0, 1}, {2, 0}, nanoseconds{70}));
  EXPECT_TRUE(wiring.connect({2, 1}, {3, 0}, nanoseconds{120}));
  EXPECT_TRUE(wiring.connect({3, 1}, {4, 0}, nanoseconds{90}));
  return wiring;
}

TEST(ClockFollowing, TheNextClockTakesOverAndNobodyJumps) {
  auto specs = random_clocks(5, 60.0);
  // Before the reference there is a clock that needs no time, so that the path to the other clocks is known.
  ClockLine line(specs, reference_on_a_branch());
  ClockRun run(line);
  auto plan = line.plan();
  plan.reference = 1;
  plan.slaves[0].signals = {};
  ASSERT_EQ(run.start(plan), "");
  run.run(seconds{2});
  static_cast<void>(run.events());

  line.line().set_power(1, false);
  line.retrace();
  auto before = line.system_time(2);
  auto when = line.clock.now();
  nanoseconds apart{0};
  nanoseconds jump{0};
  run.run(seconds{2}, [&] {
    for (const std::size_t i : {3U, 4U}) apart = std::max(apart, std::chrono::abs(line.ahead(i, 2)));
    const auto now = line.clock.now();
    const auto step = ahead_of(line.system_time(2), before) - (now - when);
    jump = std::max(jump, std::chrono::abs(step));
    before = line.system_time(2);
    when = now;
  });
  EXPECT_THAT(run.events(), testing::ElementsAre("slave 1: the reference clock no longer answers",
                                                 "slave 2: is now the reference clock"));
  EXPECT_EQ(run.clocks().reference, 2);
  // Without the branch frames arrive two microseconds earlier. The frame with the expected time, sent before the loss
  // was noticed, has shifted all clocks, and the others have to follow the new reference, which settles slowly.
  EXPECT_LE(apart, nanoseconds{500}) << "SYNC0 of the others against each other, all the time";
  EXPECT_LE(run.worst_sync0(), nanoseconds{40}) << "in the end";
  EXPECT_LE(jump, nanoseconds{200}) << "system time of a drive from cycle to cycle";
  EXPECT_TRUE(run.status().locked);
  EXPECT_EQ(run.status().unlocks, 0U);
  // The frames have the same phase to SYNC0 as before.
  EXPECT_LE(worst_arrival(run, milliseconds{200}), nanoseconds{100});
}

TEST(ClockFollowing, TheNextClockIsOneThatIsToBeSynchronised) {
  ClockLine line(random_clocks(5, 60.0), reference_on_a_branch());
  ClockRun run(line);
  auto plan = line.plan();
  plan.reference = 1;
  for (const std::size_t i : {0U, 2U}) plan.slaves[i].signals = {};
  ASSERT_EQ(run.start(plan), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  line.line().set_power(1, false);
  run.run(seconds{1});
  EXPECT_THAT(run.events(), testing::ElementsAre("slave 1: the reference clock no longer answers",
                                                 "slave 3: is now the reference clock"));
}

TEST(ClockFollowing, AReferenceThatComesBackBeforeAnybodyTookOverStays) {
  ClockLine line(random_clocks(5, 60.0), reference_on_a_branch());
  ClockRun run(line);
  auto plan = line.plan();
  plan.reference = 1;
  plan.slaves[0].signals = {};
  ASSERT_EQ(run.start(plan), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  ASSERT_TRUE(line.line().break_cable({0, 3}));
  for (int i = 0; i < 30; ++i) run.cycle();
  ASSERT_TRUE(line.line().break_cable({0, 3}, false));
  run.run(seconds{1});
  EXPECT_THAT(run.events(), testing::IsEmpty());
  EXPECT_EQ(run.clocks().reference, 1);
  EXPECT_TRUE(run.status().locked);
}

/// The loss needs eight missing frames in a row; a disturbance that costs a few is no loss.
TEST(ClockFollowing, AFewSilentFramesAreNoLossOfTheReference) {
  ClockLine line(random_clocks(5, 60.0), reference_on_a_branch());
  ClockRun run(line);
  auto plan = line.plan();
  plan.reference = 1;
  plan.slaves[0].signals = {};
  ASSERT_EQ(run.start(plan), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  ASSERT_TRUE(line.line().break_cable({0, 3}));
  for (int i = 0; i < 6; ++i) run.cycle();
  ASSERT_TRUE(run.watch().poll());
  EXPECT_THAT(run.events(), testing::IsEmpty());
  for (int i = 0; i < 6; ++i) run.cycle();
  ASSERT_TRUE(run.watch().poll());
  EXPECT_THAT(run.events(), testing::ElementsAre("slave 1: the reference clock no longer answers",
                                                 "slave 2: is now the reference clock"));
}

TEST(ClockFollowing, WithNobodyLeftTheCycleCoastsAndSaysSo) {
  ClockLine line(random_clocks(5, 60.0), reference_on_a_branch());
  ClockRun run(line);
  auto plan = line.plan();
  plan.reference = 1;
  for (const std::size_t i : {0U, 2U, 3U, 4U}) plan.slaves[i].signals = {};
  ASSERT_EQ(run.start(plan), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  const auto ppm = run.status().ppm;
  line.line().set_power(1, false);
  ASSERT_TRUE(line.line().break_cable({0, 1}));
  run.run(milliseconds{300});
  EXPECT_THAT(run.events(), testing::UnorderedElementsAre(
                                "slave 1: the reference clock no longer answers", "no clock that could replace slave 1",
                                "the cycle has lost the reference clock, slave 1: its time is not received"));
  EXPECT_NEAR(run.status().ppm, ppm, 0.1);
  EXPECT_FALSE(run.status().locked);
  EXPECT_EQ(run.status().unlocks, 1U);
}

}  // namespace
}  // namespace driveline::bus_test
