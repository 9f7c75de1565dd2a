#include "driveline/canopen_master/acyclic_port.hpp"

#include <gtest/gtest.h>

#include "cycle_rig.hpp"
#include "driveline/canopen_client/bus_link.hpp"

namespace driveline::canopen {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

const Frame kRequest = Frame::of(0x603, std::array{std::byte{0x40}, std::byte{0x41}});

class AcyclicPortTest : public testing::Test {
 protected:
  AcyclicPort port(AcyclicPort::Pass pass = {}) { return {channel, clock, 2ms, std::move(pass)}; }

  rt::VirtualClock clock{1s};
  AcyclicChannel channel{4, 2};
};

TEST_F(AcyclicPortTest, AFrameGoesToTheCycleAndStaysUntilItIsSent) {
  auto owner = port();
  EXPECT_EQ(owner.send(kRequest), SendStatus::kSent);
  ASSERT_NE(channel.next(), nullptr);
  EXPECT_EQ(*channel.next(), kRequest);
  channel.sent();
  EXPECT_EQ(channel.next(), nullptr);
}

TEST_F(AcyclicPortTest, IsBusyWhenTheCycleTakesNothing) {
  auto owner = port();
  EXPECT_EQ(owner.send(kRequest), SendStatus::kSent);
  EXPECT_EQ(owner.send(kRequest), SendStatus::kSent);
  EXPECT_EQ(owner.send(kRequest), SendStatus::kBusy);
  EXPECT_EQ(owner.send(Frame::of(0x800, {})), SendStatus::kNotValid);
}

TEST_F(AcyclicPortTest, FramesWithoutRoomAreLostAndCounted) {
  auto owner = port();
  PortStatistics below;
  below.lost = 10;
  channel.publish(below);
  for (int i = 0; i < 7; ++i) channel.deliver({kRequest, clock.now() + i * 1us});
  EXPECT_EQ(owner.statistics().lost, 13U);
  for (int i = 0; i < 4; ++i) {
    const auto frame = owner.receive();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time, clock.now() + i * 1us);
  }
  EXPECT_FALSE(owner.receive());
}

TEST_F(AcyclicPortTest, WaitingLetsCyclesPass) {
  int cycles = 0;
  auto owner = port([&](nanoseconds duration) {
    clock.advance(duration);
    if (++cycles == 3) channel.deliver({kRequest, clock.now()});
  });
  EXPECT_TRUE(owner.wait_readable(clock.now() + 20ms));
  EXPECT_EQ(clock.now(), 1s + 6ms);
  static_cast<void>(owner.receive());
  EXPECT_FALSE(owner.wait_readable(clock.now() + 5ms));
  EXPECT_EQ(clock.now(), 1s + 11ms);
}

TEST_F(AcyclicPortTest, WaitingSleepsWhereTheCycleHasItsThread) {
  auto owner = port();
  EXPECT_FALSE(owner.wait_readable(clock.now() + 5ms));
  EXPECT_EQ(clock.now(), 1s + 5ms);
}

TEST_F(AcyclicPortTest, APortThatIsGoneIsToldOnce) {
  auto owner = port();
  PortStatistics below;
  below.down = true;
  channel.publish(below);
  EXPECT_EQ(owner.send(kRequest), SendStatus::kDown);
  EXPECT_FALSE(owner.wait_readable(clock.now() + 5ms));
  EXPECT_EQ(clock.now(), 1s);
  EXPECT_FALSE(owner.wait_readable(clock.now() + 5ms));
  EXPECT_EQ(clock.now(), 1s + 5ms);
}

// A link whose queue is full sleeps on this clock, so that cycles empty the queue.
TEST_F(AcyclicPortTest, ALinkWaitsForRoomByLettingCyclesPass) {
  const auto pass = [&](nanoseconds duration) {
    clock.advance(duration);
    if (channel.next() != nullptr) channel.sent();
  };
  auto owner = port(pass);
  PassingClock passing(clock, pass);
  BusLink link(owner, passing);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(link.send(kRequest, 10ms)) << i;
  EXPECT_EQ(clock.now(), 1s + 3ms);
}

}  // namespace
}  // namespace driveline::canopen
