// Clocks of slaves that were not there when the clocks of the line were brought together.
#include <gmock/gmock.h>

#include "driveline/ecat_master/dc/clock_fault.hpp"
#include "movable_group.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::ClockPlan;
using ecat_master::dc::SlaveClockPlan;
using Place = MovableGroup::Place;

constexpr microseconds kPeriod{125};
/// True times: what the clocks are off one another is the resolution of their time stamps and their loops.
constexpr nanoseconds kNear{60};

SlaveClockPlan with_sync0(nanoseconds cycle = kPeriod, nanoseconds shift = {}) {
  return {{ecat_master::dc::kActivateSync0, cycle, shift, {}, {}}, microseconds{125}};
}

ClockPlan plan_for_two() {
  ClockPlan plan;
  plan.period = kPeriod;
  plan.frame_lead = kPeriod / 2;
  plan.slaves = {with_sync0(), with_sync0()};
  plan.joining = [](std::size_t, const esi::DeviceDescription&) { return with_sync0(); };
  return plan;
}

/// Every oscillator has a speed and a time of its own.
slaves::SlaveOptions oscillator(std::size_t drive) {
  constexpr std::array kPpm{0.0, 80.0, -45.0, 30.0, -60.0, 95.0};
  slaves::SlaveOptions options;
  options.clock.drift_ppm = kPpm[drive];
  options.clock.start = std::chrono::seconds{7 * (1 + drive)};
  return options;
}

class JoiningClock : public testing::Test {
 protected:
  void start(ClockPlan plan) {
    group.master.use_clocks(std::move(plan));
    ASSERT_EQ(sentence(group.start()), "");
    live(milliseconds{200});
  }
  void live(nanoseconds duration) {
    const auto end = group.line.clock.now() + duration;
    while (group.line.clock.now() < end) {
      group.live(milliseconds{5});
      ASSERT_EQ(sentence(group.master.clock_watch()->poll()), "");
    }
  }
  [[nodiscard]] const slaves::DistributedClock& clock_of(std::size_t drive) {
    return group.line.slave(drive).esc().clock();
  }
  void expect_together(std::initializer_list<std::size_t> drives, nanoseconds shift = {}) {
    const auto now = group.line.clock.now();
    for (const auto drive : drives) {
      const auto ahead = clock_of(drive).system_time(now) - clock_of(0).system_time(now);
      EXPECT_LE(std::chrono::abs(ahead), kNear) << "drive " << drive;
      ASSERT_TRUE(clock_of(drive).last_sync0()) << "drive " << drive;
      const auto moved = drive == 0 || drive == 3 ? nanoseconds{0} : shift;
      const auto pulses = *clock_of(drive).last_sync0() - *clock_of(0).last_sync0() - moved;
      EXPECT_LE(std::chrono::abs(ecat_master::dc::wrap_to_cycle(pulses, kPeriod)), kNear) << "drive " << drive;
    }
  }

  MovableGroup group{{}, oscillator};
};

TEST_F(JoiningClock, RunsWithTheOthersWhereverItIsPluggedIn) {
  start(plan_for_two());
  expect_together({0, 3});
  group.plug(Place::kA);
  ASSERT_TRUE(group.live_until_in_op(Place::kA)) << group.told();
  live(std::chrono::seconds{1});
  // Frames pass the branch on their way to mid, which is further from the reference clock now.
  expect_together({0, 1, 2, 3});
  group.unplug(Place::kA);
  live(milliseconds{200});
  group.plug(Place::kB);
  ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
  live(std::chrono::seconds{1});
  expect_together({0, 3, 4, 5});
  EXPECT_TRUE(group.master.clock_follower()->status().locked);
  EXPECT_FALSE(group.master.clock_watch()->out_of_window());
}

TEST_F(JoiningClock, SignalsAreThoseThatItsPlanSays) {
  auto plan = plan_for_two();
  plan.joining = [](std::size_t number, const esi::DeviceDescription& found) {
    EXPECT_EQ(found.vendor_id, slaves::msd::kVendorId);
    EXPECT_TRUE(number == MovableGroup::kHead || number == MovableGroup::kFollower);
    return with_sync0(kPeriod, microseconds{30});
  };
  start(std::move(plan));
  group.plug(Place::kB);
  ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
  live(std::chrono::seconds{1});
  expect_together({0, 3, 4, 5}, microseconds{30});
  ecat_master::CoeClient coe(*group.master.mailbox(MovableGroup::kFollower));
  EXPECT_EQ(coe.upload_as<std::uint16_t>(0x1C32, 1), 2) << "DC SYNC0";
}

TEST_F(JoiningClock, WithoutPlanItFollowsWithoutSignals) {
  auto plan = plan_for_two();
  plan.joining = {};
  start(std::move(plan));
  group.plug(Place::kB);
  ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
  live(std::chrono::seconds{1});
  const auto now = group.line.clock.now();
  EXPECT_LE(std::chrono::abs(clock_of(5).system_time(now) - clock_of(0).system_time(now)), kNear);
  EXPECT_FALSE(clock_of(5).last_sync0());
}

TEST_F(JoiningClock, PlanAgainstTheRulesIsNamedAndTheOthersGoOn) {
  auto plan = plan_for_two();
  plan.joining = [](std::size_t number, const esi::DeviceDescription&) {
    return with_sync0(number == MovableGroup::kFollower ? kPeriod * 3 : kPeriod);
  };
  start(std::move(plan));
  group.plug(Place::kB);
  live(std::chrono::seconds{2});
  EXPECT_THAT(group.told(), testing::HasSubstr("slave 2: has joined the line, is in OP\n"));
  EXPECT_THAT(group.told(), testing::HasSubstr("slave 3: not brought back to OP: "));
  EXPECT_THAT(group.told(), testing::HasSubstr("375000"));
  expect_together({0, 3, 4});
}

}  // namespace
}  // namespace driveline::bus_test
