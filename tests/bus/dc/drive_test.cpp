// Simulated drives operated with distributed clocks, from their objects to their motion.
#include <gtest/gtest.h>

#include "dc/bring_up.hpp"
#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "started_line.hpp"
#include "true_time.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::dc::ClockPlan;
using std::chrono::seconds;

ClockPlan plan_for(std::size_t drives, nanoseconds period) {
  ClockPlan plan;
  plan.period = period;
  plan.frame_lead = period / 2;
  for (std::size_t i = 0; i < drives; ++i) {
    plan.slaves.push_back({{ecat_master::dc::kActivateSync0, period, {}, {}, {}}, microseconds{125}});
  }
  return plan;
}

TEST(DrivesWithClocks, AreToldInTheirObjectsAndRunThePath) {
  DriveLine drives(3);
  LineOperation operation(drives);
  operation.master().use_clocks(plan_for(3, microseconds{125}));
  ASSERT_EQ(sentence(operation.to_motion()), "");
  for (std::size_t i = 0; i < 3; ++i) {
    CoeClient coe(*operation.master().mailbox(i));
    EXPECT_EQ(coe.upload_as<std::uint16_t>(0x1C32, 1), 2) << "DC SYNC0, drive " << i;
    EXPECT_EQ(coe.upload_as<std::uint16_t>(0x1C33, 1), 2) << "drive " << i;
    EXPECT_EQ(drives.slave(i).esc().memory().get(wire::reg::kDcActivation), 3) << "drive " << i;
  }
  EXPECT_TRUE(operation.run_until(motion::MotionPhase::kHolding, std::chrono::seconds{5}));
  EXPECT_TRUE(operation.master().clock_follower()->status().locked);
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(drives.slave(i).esc().memory().get(wire::reg::kDcActivation), 0) << i;
}

/// Also with frames that pass the drives together with a SYNC0 in between, as half a cycle before the next grid time.
TEST(DrivesWithClocks, RunWithSync0FinerThanTheCycle) {
  for (const auto sync0 : {microseconds{125}, microseconds{250}, microseconds{500}}) {
    SCOPED_TRACE(sync0.count());
    DriveLine drives(2);
    RunOptions options;
    options.period = milliseconds{1};
    LineOperation operation(drives, options);
    auto plan = plan_for(2, options.period);
    for (auto& slave : plan.slaves) slave.signals.sync0_cycle = sync0;
    operation.master().use_clocks(plan);
    ASSERT_EQ(sentence(operation.to_motion()), "");
    ASSERT_TRUE(operation.run_until(motion::MotionPhase::kHolding, seconds{5}));
    for (std::size_t i = 0; i < 2; ++i) {
      CoeClient coe(*operation.master().mailbox(i));
      EXPECT_EQ(coe.upload_as<std::uint32_t>(0x1C32, 2), static_cast<std::uint32_t>(1000 * sync0.count()))
          << "drive " << i;
      EXPECT_EQ(coe.upload_as<std::uint16_t>(0x1C32, 0x0B), 0) << "no setpoint was missed, drive " << i;
      EXPECT_EQ(drives.state(i), wire::AlState::kOp) << "drive " << i;
      EXPECT_FALSE(drives.drive(i).fault()) << "drive " << i;
    }
    EXPECT_EQ(sentence(operation.master().shut_down()), "");
  }
}

/// The wait for SYNC0 delays a setpoint further, and it must be compared with the matching position.
TEST(DrivesWithClocks, HaveTheFollowingErrorThatTheyReport) {
  for (const auto period : {nanoseconds{microseconds{125}}, nanoseconds{milliseconds{1}}}) {
    DriveLine drives(2);
    RunOptions options;
    options.period = period;
    options.setpoint_delay_cycles = motion::setpoint_delay_cycles({period, 1, motion::kSplinePeriods, period / 2});
    LineOperation operation(drives, options);
    operation.master().use_clocks(plan_for(2, period));
    follow_path(operation);
    operation.axis_samples.clear();
    ASSERT_TRUE(operation.run_until(motion::MotionPhase::kHolding, seconds{2}));
    double difference = 0.0;
    for (const auto& sample : operation.axis_samples) {
      difference = std::max(difference, std::abs(sample.following_error - sample.drive_following_error));
    }
    // At 8 rad/s a wrong cycle of 125 us would be 1 mrad.
    EXPECT_LT(difference, 1e-4) << period.count();
  }
}

/// The last two drives lose their supply and return while the first two continue.
TEST(DrivesWithClocks, GetTheirTimeBackWhenTheyComeBack) {
  DriveLine drives(4);
  LineOperation operation(drives);
  operation.master().use_clocks(plan_for(4, microseconds{125}));
  ASSERT_EQ(sentence(operation.to_op()), "");
  ecat_master::LineSupervisor supervisor(operation.master());
  operation.run(milliseconds{500});
  drives.line().set_power(2, false);
  for (int i = 0; i < 20; ++i) {
    operation.run(milliseconds{5});
    supervisor.poll();
  }
  ASSERT_FALSE(supervisor.all_operational());
  drives.line().set_power(2, true);
  for (int i = 0; i < 1000 && !supervisor.all_operational(); ++i) {
    operation.run(milliseconds{5});
    supervisor.poll();
    ASSERT_EQ(sentence(operation.master().clock_watch()->poll()), "");
  }
  ASSERT_TRUE(supervisor.all_operational()) << describe(supervisor.history().back());
  operation.run(seconds{1});
  const auto now = drives.clock.now();
  for (std::size_t i = 1; i < 4; ++i) {
    const auto ahead = drives.slave(i).esc().clock().system_time(now) - drives.slave(0).esc().clock().system_time(now);
    EXPECT_LE(std::chrono::abs(ahead), nanoseconds{40}) << "drive " << i;
    const auto pulses = *drives.slave(i).esc().clock().last_sync0() - *drives.slave(0).esc().clock().last_sync0();
    EXPECT_LE(std::chrono::abs(off_beat(pulses, microseconds{125})), nanoseconds{40}) << i;
    EXPECT_EQ(drives.state(i), wire::AlState::kOp) << "drive " << i;
  }
}

TEST(DrivesWithClocks, ACycleThatIsNoMultipleOf125MicrosecondsIsRefused) {
  DriveLine drives(2);
  LineOperation operation(drives);
  operation.master().use_clocks(plan_for(2, microseconds{200}));
  EXPECT_EQ(sentence(operation.to_safe_op()), "slave 0: the SYNC0 cycle of 200000 ns is not a multiple of 125000 ns");
}

}  // namespace
}  // namespace driveline::bus_test
