#include "driveline/slaves/endpoint/endpoint_protocol.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <vector>

namespace driveline::slaves {
namespace {

TEST(EndpointPacket, BeginsWithVersionAndKind) {
  EndpointPacket packet;
  ASSERT_TRUE(packet.write(EndpointMessage::kLink, EndpointLink{1}));
  std::vector<unsigned> bytes;
  for (const auto byte : packet.bytes()) bytes.push_back(std::to_integer<unsigned>(byte));
  EXPECT_THAT(bytes, testing::ElementsAre(1, 0, 3, 0, 1));
}

TEST(EndpointPacket, GivesBackWhatWasPutIn) {
  EndpointPacket packet;
  const EndpointAddress address{{std::byte{2}}, {192, 168, 38, 5}, {255, 255, 255, 0}, {192, 168, 38, 1}};
  ASSERT_TRUE(packet.write(EndpointMessage::kAddress, address));
  EXPECT_EQ(packet.message(), EndpointMessage::kAddress);
  EXPECT_EQ(packet.content_as<EndpointAddress>(), address);
  EXPECT_FALSE(packet.content_as<EndpointLink>().has_value()) << "another length";
}

TEST(EndpointPacket, IsNotUnderstoodWhenItIsShortOrOfAnotherVersion) {
  EndpointPacket packet;
  const auto receive = [&packet](std::vector<unsigned> bytes) {
    std::transform(bytes.begin(), bytes.end(), packet.room().begin(),
                   [](unsigned b) { return static_cast<std::byte>(b); });
    packet.set_length(bytes.size());
  };
  receive({1, 0, 3});
  EXPECT_FALSE(packet.message().has_value());
  receive({2, 0, 3, 0, 1});
  EXPECT_FALSE(packet.message().has_value());
  packet.set_length(packet.room().size() + 1);
  EXPECT_FALSE(packet.message().has_value()) << "cut off";
  receive({1, 0, 5, 0});
  EXPECT_EQ(packet.message(), EndpointMessage::kReady);
  EXPECT_TRUE(packet.content().empty());
}

TEST(EndpointPacket, HasRoomForTheLongestFrameAndNoMoreThanItHas) {
  EndpointPacket packet;
  EXPECT_TRUE(packet.write(EndpointMessage::kFrame, std::vector<std::byte>(wire::kMaxEoeFrame)));
  EXPECT_FALSE(packet.write(EndpointMessage::kFrame, std::vector<std::byte>(EndpointPacket::kMaxContent + 1)));
}

}  // namespace
}  // namespace driveline::slaves
