// The clocks of a ring: whole, broken anywhere, healed; judged by their true times.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clock_run.hpp"
#include "driveline/port/redundant_port.hpp"

namespace driveline::bus_test {
namespace {

using slaves::Wiring;

constexpr std::size_t kSlaves = 8;

/// Eight clocks in a ring whose frequencies drift by 1 ppm/s: a clock without reference time is off by microseconds
/// within seconds.
class ClockRing : public testing::Test {
 protected:
  static std::vector<ClockSpec> wandering() {
    auto specs = random_clocks(kSlaves, 60.0);
    for (auto& spec : specs) spec.temperature_ppm_per_s = 1.0;
    return specs;
  }
  void start(nanoseconds period = microseconds{125}) {
    ClockRun::Options options;
    options.port = &ring;
    options.ring = &ring;
    run = std::make_unique<ClockRun>(line, options);
    ASSERT_EQ(run->start(line.plan(period)), "");
    run->run(seconds{1});
    static_cast<void>(run->events());
  }
  /// Cable n precedes slave n; cable kSlaves leads back to the master.
  void cut(std::size_t cable, bool broken = true) {
    const slaves::PortId end = cable == 0 ? slaves::PortId{0, 0} : slaves::PortId{cable - 1, 1};
    ASSERT_TRUE(line.line().break_cable(end, broken));
  }
  /// Largest true distance of any SYNC0 from that of the reference clock over `duration`.
  nanoseconds worst(nanoseconds duration) {
    nanoseconds found{0};
    run->run(duration, [&] {
      found = std::max(found, run->worst_sync0());
      EXPECT_EQ(run->master().core()->bad_cycles(), 0U);
    });
    return found;
  }

  ClockLine line{wandering(), Wiring::ring(kSlaves, nanoseconds{25})};
  port::RedundantPort ring{line.line(), line.line().secondary(), line.clock};
  std::unique_ptr<ClockRun> run;
};

TEST_F(ClockRing, WholeItIsLikeALine) {
  start();
  EXPECT_LE(worst(seconds{1}), nanoseconds{40});
  EXPECT_THAT(run->events(), testing::IsEmpty());
}

TEST_F(ClockRing, BothPartsStayTogetherWhereverItBreaks) {
  start();
  for (std::size_t cable = 1; cable <= kSlaves; ++cable) {
    SCOPED_TRACE(cable);
    cut(cable);
    EXPECT_LE(worst(seconds{3}), nanoseconds{60});
    std::vector<std::string> told;
    if (cable < kSlaves) {
      told.push_back("the ring is open before slave " + std::to_string(cable) +
                     ": the clocks from there on are led by the second interface");
    }
    EXPECT_EQ(run->events(), told);
    cut(cable, false);
    EXPECT_LE(worst(seconds{1}), nanoseconds{60}) << "healed";
    if (cable < kSlaves) {
      EXPECT_EQ(run->events(), std::vector<std::string>{"the ring is closed: one frame leads all clocks again"});
    }
    EXPECT_TRUE(run->status().locked);
    EXPECT_EQ(run->status().unlocks, 0U);
  }
}

/// Without reference time the far part drifts away, which shows that the previous test is meaningful.
TEST_F(ClockRing, ClocksBehindTheBreakWouldRunAway) {
  ClockRun::Options options;
  options.port = &ring;
  run = std::make_unique<ClockRun>(line, options);
  ASSERT_EQ(run->start(line.plan()), "");
  run->run(seconds{1});
  cut(4);
  EXPECT_GT(worst(seconds{3}), microseconds{1});
}

/// Before the first slave: all slaves are now reached from the other end only, including the reference clock.
TEST_F(ClockRing, ABreakInFrontOfTheReferenceClockLeavesItTheReference) {
  start();
  cut(0);
  EXPECT_LE(worst(seconds{3}), nanoseconds{60});
  EXPECT_EQ(run->clocks().reference, 0);
  EXPECT_TRUE(run->status().locked);
  EXPECT_THAT(run->events(), testing::Contains("the ring is open before slave 0: the clocks from there on are led "
                                               "by the second interface"));
  cut(0, false);
  EXPECT_LE(worst(seconds{2}), nanoseconds{60});
  EXPECT_EQ(run->clocks().reference, 0);
  EXPECT_TRUE(run->status().locked);
}

TEST_F(ClockRing, ABreakElsewhereRightAfterHealingIsFollowed) {
  start();
  cut(2);
  EXPECT_LE(worst(seconds{1}), nanoseconds{60});
  cut(2, false);
  run->run(milliseconds{1});
  cut(6);
  EXPECT_LE(worst(seconds{2}), nanoseconds{60});
  EXPECT_TRUE(run->status().locked);
}

TEST_F(ClockRing, DelaysAreMeasuredAgainWhileItIsClosed) {
  start();
  ASSERT_TRUE(run->master().topology().ring_end) << "no ring was found";
  run->run(milliseconds{50});
  ASSERT_TRUE(run->watch().remeasure_delays(run->master().topology()));
  EXPECT_EQ(run->master().core()->bad_cycles(), 0U);
  EXPECT_LE(worst(milliseconds{200}), nanoseconds{40});
  EXPECT_THAT(run->events(), testing::IsEmpty()) << "nothing has changed";
  EXPECT_EQ(ring.status().state, port::RingStatus::State::kClosed) << "closed again";
  // The cable before slave 3 has become 300 ns longer than the slaves assume.
  auto wrong = run->clocks();
  for (std::size_t i = 3; i < kSlaves; ++i) wrong.slaves[i].delay -= 300;
  ecat_master::dc::ClockWatch other(run->master().bus(), line.refs(), wrong, *run->master().clock_follower());
  other.use_ring(ring);
  ASSERT_TRUE(other.remeasure_delays(run->master().topology()));
  EXPECT_EQ(other.take_events().size(), kSlaves - 3);
  for (std::size_t i = 1; i < kSlaves; ++i) {
    EXPECT_NEAR(static_cast<double>(line.slave(i).esc().memory().get(wire::reg::kSystemTimeDelay)),
                line.true_delay(0, i), 10.0)
        << i;
  }
}

/// If the ring broke while it is open for the measurement, the far part would stay out of reach.
TEST_F(ClockRing, ABreakWhileItIsOpenForTheMeasurementDoesNotLast) {
  start();
  const auto& end = *run->master().topology().ring_end;
  const auto closed_for_now = 0x0000'0002U | (0x3U << (8 + 2 * end.port));
  ASSERT_TRUE(run->master().bus().write(line.refs()[end.slave], wire::reg::kDlControl, 0x0000'0001U | closed_for_now));
  cut(3);
  run->run(milliseconds{1500});
  EXPECT_EQ(ring.status().primary_slaves, 3);
  EXPECT_EQ(ring.status().secondary_slaves, kSlaves - 3);
  EXPECT_EQ(run->master().core()->bad_cycles(), 0U);
}

}  // namespace
}  // namespace driveline::bus_test
