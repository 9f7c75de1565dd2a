// Simulated drives run with distributed clocks, from their objects to their motion.
#include <gtest/gtest.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/dc/bring_up.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::dc::ClockPlan;

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
  EXPECT_TRUE(operation.run_until(ecat_master::MotionPhase::kHolding, std::chrono::seconds{5}));
  EXPECT_TRUE(operation.master().clock_follower()->status().locked);
  EXPECT_EQ(sentence(operation.master().shut_down()), "");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(drives.slave(i).esc().memory().get(wire::reg::kDcActivation), 0) << i;
}

TEST(DrivesWithClocks, ACycleThatIsNoMultipleOf125MicrosecondsIsRefused) {
  DriveLine drives(2);
  LineOperation operation(drives);
  operation.master().use_clocks(plan_for(2, microseconds{200}));
  EXPECT_EQ(sentence(operation.to_safe_op()), "slave 0: the SYNC0 cycle of 200000 ns is not a multiple of 125000 ns");
}

}  // namespace
}  // namespace driveline::bus_test
