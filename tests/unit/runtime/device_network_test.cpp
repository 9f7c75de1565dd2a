// Frames, addresses and link between a device and the thread of its end point.
#include "endpoints/device_network.hpp"

#include <gmock/gmock.h>

#include <vector>

#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::runtime {
namespace {

std::vector<std::byte> frame(std::size_t length, unsigned first = 0) {
  std::vector<std::byte> bytes(length, std::byte{0x5A});
  bytes.front() = static_cast<std::byte>(first);
  return bytes;
}

struct Rig {
  slaves::msd::MsdDrive drive;
  DeviceNetwork network{drive, 4};
  NetworkFrame taken;
  std::vector<std::byte> room = std::vector<std::byte>(wire::kMaxEoeFrame);
};

TEST(DeviceNetwork, CarriesFramesBothWaysAndDropsWhatHasNoRoom) {
  Rig rig;
  for (unsigned i = 0; i < 4; ++i) EXPECT_TRUE(rig.network.send(frame(60 + i, i)));
  EXPECT_FALSE(rig.network.send(frame(60)));
  EXPECT_EQ(rig.network.dropped(), 1U);
  for (unsigned i = 0; i < 4; ++i) {
    ASSERT_TRUE(rig.network.next_frame(rig.taken));
    EXPECT_EQ(rig.taken.length, 60 + i);
    EXPECT_EQ(rig.taken.bytes[0], static_cast<std::byte>(i));
  }
  EXPECT_FALSE(rig.network.next_frame(rig.taken));
  rig.taken.length = 77;
  for (int i = 0; i < 4; ++i) rig.network.offer(rig.taken);
  EXPECT_FALSE(rig.network.has_room());
  EXPECT_EQ(rig.network.receive(rig.room), 77U);
  EXPECT_TRUE(rig.network.has_room());
}

TEST(DeviceNetwork, RefusesFramesThatAreTooLong) {
  Rig rig;
  EXPECT_TRUE(rig.network.send(frame(wire::kMaxEoeFrame)));
  EXPECT_FALSE(rig.network.send(frame(wire::kMaxEoeFrame + 1)));
  rig.taken.length = 100;
  rig.network.offer(rig.taken);
  EXPECT_EQ(rig.network.receive(std::span(rig.room).first(99)), 0U);
}

TEST(DeviceNetwork, TellsTheLatestAddressAndForgetsFramesWithTheLink) {
  Rig rig;
  EXPECT_TRUE(rig.drive.connect_network(&rig.network));
  EXPECT_EQ(rig.network.address().ip, (wire::IpV4Address{192, 168, 39, 5}));
  EXPECT_FALSE(rig.network.link_up());
  static_cast<void>(rig.drive.transition(wire::AlState::kInit, wire::AlState::kPreOp));
  EXPECT_TRUE(rig.network.link_up());
  rig.taken.length = 60;
  rig.network.offer(rig.taken);
  static_cast<void>(rig.drive.transition(wire::AlState::kPreOp, wire::AlState::kInit));
  EXPECT_FALSE(rig.network.link_up());
  EXPECT_EQ(rig.network.receive(rig.room), 0U);
}

TEST(DeviceNetwork, TheDeviceTellsItsStatusOnceForEachQuestion) {
  Rig rig;
  slaves::DeviceStatus status;
  EXPECT_EQ(rig.network.receive(rig.room), 0U);
  EXPECT_FALSE(rig.network.next_status(status));
  rig.network.ask_for_status();
  EXPECT_EQ(rig.network.receive(rig.room), 0U);
  EXPECT_EQ(rig.network.receive(rig.room), 0U);
  ASSERT_TRUE(rig.network.next_status(status));
  EXPECT_EQ(status.type.view(), "MSD Servo Drive");
  EXPECT_FALSE(rig.network.next_status(status));
}

}  // namespace
}  // namespace driveline::runtime
