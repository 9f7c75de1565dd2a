// Clocks of slaves that were missing when the clocks of the line were synchronised.
#include <gmock/gmock.h>

#include "fault_ports.hpp"
#include "movable_group.hpp"
#include "true_time.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::dc::ClockPlan;
using ecat_master::dc::SlaveClockPlan;
using Place = MovableGroup::Place;

constexpr microseconds kPeriod{125};
/// True times: the differences between clocks are due to the resolution of their time stamps and to their loops.
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

/// Every oscillator has its own frequency and time.
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
      EXPECT_LE(std::chrono::abs(off_beat(pulses, kPeriod)), kNear) << "drive " << drive;
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
  // Frames pass the branch before mid, which is now further away from the reference clock.
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
  EXPECT_THAT(group.told(), testing::HasSubstr("slave 2: joined the line and is in OP\n"));
  EXPECT_THAT(group.told(), testing::HasSubstr("slave 3: not brought back to OP: "));
  EXPECT_THAT(group.told(), testing::HasSubstr("375000"));
  expect_together({0, 3, 4});
}

/// Delays the frame that activates the signals of a slave, once.
class SlowActivation final : public PassingPort {
 public:
  SlowActivation(EditedLine& line, std::uint16_t station)
      : PassingPort(line.line()), clock_(line.clock), station_(station) {}
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    if (!done_ && activates(frame)) {
      done_ = true;
      clock_.advance(milliseconds{40});
    }
    return inner_.send(frame);
  }
  [[nodiscard]] bool done() const noexcept { return done_; }

 private:
  /// Ethernet and EtherCAT header are 16 bytes; a datagram has 10 of header and 2 of working counter around its data.
  [[nodiscard]] bool activates(std::span<const std::byte> frame) const noexcept {
    for (std::size_t at = 16; at + 12 <= frame.size();) {
      const auto word = [&](std::size_t offset) {
        return bytes::load_le<std::uint16_t>(frame.subspan(at + offset, 2));
      };
      if (frame[at] == static_cast<std::byte>(wire::Command::kFpwr) && word(2) == station_ &&
          word(4) == wire::reg::kDcActivation.address) {
        return true;
      }
      if ((word(6) & 0x8000U) == 0) return false;
      at += 12U + (word(6) & 0x07FFU);
    }
    return false;
  }

  rt::VirtualClock& clock_;
  std::uint16_t station_;
  bool done_ = false;
};

/// The signals of a joining slave are activated again if their start time has passed; those of other slaves are not
/// touched.
TEST(JoiningClocks, ThatStartTwiceLeaveTheOthersAlone) {
  SlowActivation* slow = nullptr;
  static constexpr std::uint16_t kStation = 0x1003;
  MovableGroup group({}, oscillator, [&slow](EditedLine& line) -> std::unique_ptr<port::Port> {
    auto port = std::make_unique<SlowActivation>(line, kStation);
    slow = port.get();
    return port;
  });
  group.master.use_clocks(plan_for_two());
  ASSERT_EQ(sentence(group.start()), "");
  ASSERT_EQ(group.master.slaves()[2].info.ref.station, kStation);
  group.live(milliseconds{100});
  group.plug(Place::kB);
  ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
  EXPECT_TRUE(slow->done());
  for (const std::size_t drive : {0U, 3U, 4U, 5U}) {
    EXPECT_EQ(group.line.slave(drive).esc().memory().get(wire::reg::kDcActivation), 3) << "drive " << drive;
    EXPECT_EQ(group.line.slave(drive).state(), wire::AlState::kOp) << "drive " << drive;
  }
}

}  // namespace
}  // namespace driveline::bus_test
