// Supervision of the clocks while the cycle runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clock_run.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::ClockWatch;

TEST(ClockWatch, CollectsTheDifferencesOfAllSlaves) {
  ClockLine line(random_clocks(4, 100.0));
  ClockRun run(line);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{1});
  run.watch().restart_statistics();
  run.run(seconds{1});
  EXPECT_EQ(run.watch().differences(0).count(), 0U) << "the reference clock has none";
  for (const std::size_t i : {1U, 2U, 3U}) EXPECT_GE(run.watch().differences(i).count(), 199U) << i;
  const auto all = run.watch().all_differences();
  EXPECT_EQ(all.count(), run.watch().differences(1).count() + run.watch().differences(2).count() +
                             run.watch().differences(3).count());
  EXPECT_LE(all.max(), nanoseconds{200});
  EXPECT_FALSE(run.watch().out_of_window());
}

TEST(ClockWatch, AClockThatLeavesItsWindowIsNamed) {
  ClockLine line(random_clocks(3, 20.0));
  ClockRun run(line);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  // Another master writes the offset of slave 2: its clock is then 50 us ahead and must be corrected.
  const auto offset = line.slave(2).esc().memory().get(wire::reg::kSystemTimeOffset);
  ASSERT_TRUE(run.master().bus().write(line.refs()[2], wire::reg::kSystemTimeOffset, offset + 50'000));
  run.run(milliseconds{10});
  EXPECT_EQ(run.watch().out_of_window(), 2);
  run.run(seconds{1});
  EXPECT_FALSE(run.watch().out_of_window());
  const auto events = run.events();
  ASSERT_GE(events.size(), 2U);
  EXPECT_THAT(events.front(), testing::MatchesRegex("slave 2: its clock is [0-9]+ ns off the reference clock"));
  EXPECT_THAT(events.back(), testing::MatchesRegex("slave 2: its clock is back within its window, -?[0-9]+ ns off"));
}

/// The window is one microsecond: drives 3 us apart are named, 300 ns are not.
TEST(ClockWatch, TheWindowIsAMicrosecond) {
  for (const auto& [offset, outside] : {std::pair(3000, true), std::pair(-3000, true), std::pair(300, false)}) {
    SCOPED_TRACE(offset);
    ClockLine line(random_clocks(3, 20.0));
    ClockRun run(line);
    ASSERT_EQ(run.start(line.plan()), "");
    run.run(seconds{1});
    static_cast<void>(run.events());
    const auto before = line.slave(2).esc().memory().get(wire::reg::kSystemTimeOffset);
    ASSERT_TRUE(run.master().bus().write(line.refs()[2], wire::reg::kSystemTimeOffset,
                                         before + static_cast<std::uint64_t>(std::int64_t{offset})));
    run.run(milliseconds{10});
    EXPECT_EQ(run.watch().out_of_window().has_value(), outside);
    run.run(seconds{1});
    EXPECT_FALSE(run.watch().out_of_window());
    EXPECT_EQ(run.events().size(), outside ? 2U : 0U);
  }
}

TEST(ClockWatch, DelaysAreMeasuredAgainWhileTheCycleRuns) {
  slaves::LineOptions options;
  options.cable_delay = nanoseconds{50};
  ClockLine line(random_clocks(4, 50.0), std::nullopt, options);
  ClockRun run(line);
  ASSERT_EQ(run.start(line.plan()), "");
  run.run(seconds{1});
  static_cast<void>(run.events());
  ASSERT_TRUE(run.watch().remeasure_delays(run.master().topology()));
  EXPECT_THAT(run.events(), testing::IsEmpty()) << "nothing has changed";

  // A watch with a wrong delay of slave 2 finds the true one and writes it.
  auto wrong = run.clocks();
  const auto truth = wrong.slaves[2].delay;
  wrong.slaves[2].delay += 500;
  ClockWatch other(run.master().bus(), line.refs(), wrong, *run.master().clock_follower());
  ASSERT_TRUE(run.master().bus().write(line.refs()[2], wire::reg::kSystemTimeDelay, truth + 500));
  ASSERT_TRUE(other.remeasure_delays(run.master().topology()));
  const auto events = other.take_events();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].slave, 2);
  EXPECT_NEAR(static_cast<double>(events[0].value_ns), -500.0, 2.0);
  EXPECT_NEAR(static_cast<double>(line.slave(2).esc().memory().get(wire::reg::kSystemTimeDelay)), truth, 2.0);
  EXPECT_EQ(line.slave(2).state(), wire::AlState::kOp);
}

}  // namespace
}  // namespace driveline::bus_test
