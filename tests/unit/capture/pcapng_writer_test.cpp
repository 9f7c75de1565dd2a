#include "driveline/capture/pcapng_writer.hpp"

#include <gmock/gmock.h>

#include <string>

#include "support/pcapng_blocks.hpp"

namespace driveline::capture {
namespace {

using namespace std::chrono_literals;
using namespace pcapng_test;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::Pair;
using ::testing::SizeIs;

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  std::string digits;
  for (const char character : text) {
    if (character == ' ') continue;
    digits += character;
    if (digits.size() == 2) {
      bytes.push_back(static_cast<std::byte>(std::stoul(digits, nullptr, 16)));
      digits.clear();
    }
  }
  return bytes;
}

// The expected bytes are put together by hand from the figures of draft-ietf-opsawg-pcapng (4.1, 4.2, 4.3, 4.6).

TEST(PcapngWriter, HeaderIsSectionAndInterfaceByteForByte) {
  Bytes sink;
  PcapngWriter{sink}.header("eth0");
  EXPECT_THAT(sink, ElementsAreArray(from_hex(
                        // Section Header Block, 48 bytes, magic, version 1.0, section length unknown
                        "0a0d0d0a 30000000 4d3c2b1a 0100 0000 ffffffffffffffff"
                        // shb_userappl "driveline" padded to 12, end of options, length
                        "0400 0900 64726976656c696e65 000000 0000 0000 30000000"
                        // Interface Description Block, 48 bytes, LINKTYPE_ETHERNET, no limit of length
                        "01000000 30000000 0100 0000 00000000"
                        // if_name "eth0", if_tsresol 9, if_fcslen 0, end of options, length
                        "0200 0400 65746830 0900 0100 09000000 0d00 0100 00000000 0000 0000 30000000")));
}

TEST(PcapngWriter, PacketIsEnhancedPacketBlockByteForByte) {
  Bytes sink;
  const Bytes frame = from_hex("ffffffffffff 020000000001 88a4 0110 07");  // 17 bytes: 3 of padding
  // 0x0001020304050607 ns
  PcapngWriter{sink}.packet({283686952306183ns, CaptureDirection::kOutbound, 0, frame});
  EXPECT_THAT(sink, ElementsAreArray(from_hex("06000000 40000000 00000000"
                                              // time stamp: upper half first
                                              "03020100 07060504 11000000 11000000"
                                              "ffffffffffff 020000000001 88a4 0110 07 000000"
                                              // epb_flags outbound
                                              "0200 0400 02000000 0000 0000 40000000")));
}

TEST(PcapngWriter, StatisticsAreInterfaceStatisticsBlockByteForByte) {
  Bytes sink;
  PcapngWriter{sink}.statistics(283686952306183ns, 0x0102, 3);
  EXPECT_THAT(sink, ElementsAreArray(from_hex("05000000 34000000 00000000 03020100 07060504"
                                              "0400 0800 0201000000000000 0500 0800 0300000000000000"
                                              "0000 0000 34000000")));
}

TEST(PcapngWriter, EveryFrameLengthIsPaddedAndComesBackWhole) {
  Bytes sink;
  PcapngWriter writer{sink};
  writer.header("");
  Bytes frame;
  for (std::size_t size = 0; size <= 1518; ++size) {
    writer.packet({std::chrono::nanoseconds{size}, CaptureDirection::kInbound, 0, frame});
    frame.push_back(static_cast<std::byte>(size * 7));
  }
  const auto packets = pcapng_packets(sink);
  ASSERT_THAT(packets, SizeIs(1519));
  for (std::size_t size = 0; size < packets.size(); ++size) {
    ASSERT_EQ(packets[size].time_ns, size);
    ASSERT_THAT(packets[size].frame, ElementsAreArray(std::span{frame}.first(size)));
    ASSERT_THAT(packets[size].options, ElementsAre(Pair(2, 1)));  // inbound, nothing dropped
  }
}

TEST(PcapngWriter, DropsBeforeAPacketAreNoted) {
  Bytes sink;
  PcapngWriter{sink}.packet({1ns, CaptureDirection::kInbound, 0x1'0000'0002, {}});
  EXPECT_THAT(pcapng_packets(sink).at(0).options, ElementsAre(Pair(2, 1), Pair(4, 0x1'0000'0002)));
}

TEST(PcapngWriter, TimeBefore1970BecomesZero) {
  Bytes sink;
  PcapngWriter{sink}.packet({-1ns, CaptureDirection::kInbound, 0, {}});
  EXPECT_EQ(pcapng_packets(sink).at(0).time_ns, 0U);
}

TEST(PcapngWriter, InterfaceWithoutNameHasNoNameOption) {
  Bytes sink;
  PcapngWriter{sink}.header("");
  EXPECT_THAT(pcapng_options(pcapng_blocks(sink).at(1), 8), ElementsAre(Pair(9, 9), Pair(13, 0)));
}

TEST(PcapngWriter, AnInterfaceOfCanHasItsLinkTypeAndNoFcs) {
  Bytes sink;
  PcapngWriter{sink, LinkType::kCanSocketcan}.header("");
  const auto interface = pcapng_blocks(sink).at(1);
  EXPECT_EQ(number(interface.body, 0, 2), 227U);  // LINKTYPE_CAN_SOCKETCAN
  EXPECT_THAT(pcapng_options(interface, 8), ElementsAre(Pair(9, 9)));
}

}  // namespace
}  // namespace driveline::capture
