// Ethernet over EtherCAT of the drive (MSD manual 7.6).
#include <gmock/gmock.h>

#include "drive_rig.hpp"
#include "driveline/wire/eoe.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;

/// The network side of the drive's EoE port.
struct Plug final : EthernetLink {
  bool send(std::span<const std::byte> /*frame*/) noexcept override { return ++frames != 0; }
  std::size_t receive(std::span<std::byte> /*out*/) noexcept override { return 0; }
  void set_address(const wire::EoeIpParameters& parameters) noexcept override { address = parameters; }
  void set_link(bool link) noexcept override { up = link; }
  unsigned frames = 0;
  bool up = false;
  wire::EoeIpParameters address;
};

/// Sends an EoE message; returns the answer with its header, cut to its length.
std::vector<unsigned> eoe(MsdDrive& drive, std::vector<unsigned> data) {
  std::vector<std::byte> mail(512);
  data.insert(data.begin(), {static_cast<unsigned>(data.size()), 0, 0, 0, 0, 0x02});
  for (std::size_t i = 0; i < data.size(); ++i) mail[i] = static_cast<std::byte>(data[i]);
  EXPECT_TRUE(drive.takes_mailbox(mail));
  drive.mailbox_request(mail);
  const auto length = drive.mailbox_reply(mail);
  std::vector<unsigned> answer;
  for (std::size_t i = 0; i < length; ++i) answer.push_back(std::to_integer<unsigned>(mail[i]));
  return answer;
}

TEST(MsdEthernet, HasTheAddressOfTheFactoryUntilTheMasterSetsAnother) {
  DriveRig rig;
  Plug plug;
  ASSERT_TRUE(rig.device.connect_network(&plug));
  EXPECT_TRUE(plug.up);
  EXPECT_EQ(plug.address.ip, (wire::IpV4Address{192, 168, 39, 5}));
  EXPECT_EQ(plug.address.subnet_mask, (wire::IpV4Address{255, 255, 255, 0}));
  // Set IP 192.168.38.5 alone.
  const auto answer = eoe(rig.device, {0x02, 0x01, 0, 0, 0x02, 0, 0, 0, 5, 38, 168, 192});
  EXPECT_THAT(std::vector<unsigned>(answer.begin() + 6, answer.end()), ElementsAre(0x03, 0x01, 0, 0));
  EXPECT_EQ(plug.address.ip, (wire::IpV4Address{192, 168, 38, 5}));
  rig.to(AlState::kPreOp, AlState::kInit);
  EXPECT_FALSE(plug.up);
  rig.to(AlState::kInit, AlState::kPreOp);
  EXPECT_EQ(plug.address.ip, (wire::IpV4Address{192, 168, 38, 5})) << "as long as the power";
  rig.restart();
  EXPECT_EQ(plug.address.ip, (wire::IpV4Address{192, 168, 39, 5}));
}

TEST(MsdEthernet, FramesPassAboveInitButNotInBootstrap) {
  const std::vector<unsigned> frame = [] {
    std::vector<unsigned> mail = {0x00, 0x01, 0x80, 0x10};
    mail.resize(4 + 60);
    return mail;
  }();
  DriveRig rig;
  Plug plug;
  ASSERT_TRUE(rig.device.connect_network(&plug));
  EXPECT_TRUE(eoe(rig.device, frame).empty());
  EXPECT_EQ(plug.frames, 1U);
  rig.to(AlState::kPreOp, AlState::kInit);
  rig.to(AlState::kInit, AlState::kBootstrap);
  EXPECT_FALSE(plug.up);
  for (const auto& mail : {frame, {0x06, 0x01, 0, 0}}) {
    const auto answer = eoe(rig.device, mail);
    EXPECT_THAT(std::vector<unsigned>(answer.begin() + 6, answer.end()), ElementsAre(1, 0, 2, 0))
        << "mailbox error: unsupported protocol";
  }
  EXPECT_EQ(plug.frames, 1U);
}

TEST(MsdEthernet, DrivesWithDifferentSerialNumbersHaveDifferentMacAddresses) {
  MsdParameters parameters;
  parameters.serial_number = 1000;
  const MsdDrive first(parameters);
  parameters.serial_number = 1001;
  const MsdDrive second(parameters);
  EXPECT_NE(first.eoe().address().mac, second.eoe().address().mac);
  EXPECT_EQ(std::to_integer<unsigned>(first.eoe().address().mac->front()), 0x02U) << "locally administered";
}

}  // namespace
}  // namespace driveline::slaves::msd
