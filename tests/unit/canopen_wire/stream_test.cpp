// Frames as captures of link type 227 and streams of cannelloni have them.
#include <gtest/gtest.h>

#include "driveline/canopen_wire/cannelloni_tcp.hpp"
#include "driveline/canopen_wire/slcan.hpp"
#include "driveline/canopen_wire/socketcan.hpp"
#include "support/bytes.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;

struct PacketRow {
  Frame frame;
  std::string_view packet;
};

// By the table of LINKTYPE_CAN_SOCKETCAN of tcpdump.org and the flags of linux/can.h.
const std::vector<PacketRow> kPacketRows{
    {Frame::of(0x123, hex("11 22")), "00 00 01 23 02 00 00 00 11 22 00 00 00 00 00 00"},
    {Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 02 03 04 05 06 07 08")),
     "9A AA AA AA 08 00 00 00 01 02 03 04 05 06 07 08"},
    {Frame::remote({0x70A, false}, 4), "40 00 07 0A 04 00 00 00 00 00 00 00 00 00 00 00"},
    {Frame::remote({0x100, true}, 0), "C0 00 01 00 00 00 00 00 00 00 00 00 00 00 00 00"},
    {Frame{{}, FrameKind::kError, 0, {}}, "20 00 00 80 08 00 00 00 00 00 00 00 00 00 00 00"},
};

TEST(SocketcanPacket, GoldenBytes) {
  for (const auto& row : kPacketRows) {
    EXPECT_EQ(copy_of(socketcan::packet_of(row.frame)), hex(row.packet));
    EXPECT_EQ(socketcan::parse_packet(hex(row.packet)), row.frame) << row.packet;
  }
}

TEST(SocketcanPacket, WhatIsNoFrameIsNotRead) {
  for (const std::string_view packet :
       {"", "00 00 01 23 00", "00 00 08 00 00 00 00 00 00 00 00 00 00 00 00 00",
        "00 00 01 23 09 00 00 00 00 00 00 00 00 00 00 00", "00 00 01 23 00 00 00 00 00 00 00 00 00 00 00 00 00"}) {
    EXPECT_FALSE(socketcan::parse_packet(hex(packet))) << packet;
  }
}

// doc/tcp_protocol.md of cannelloni.
TEST(CannelloniStream, GoldenBytes) {
  EXPECT_EQ(copy_of(cannelloni::stream_frame_of(Frame::of(0x123, hex("11 22"))).view()), hex("00 00 01 23 02 11 22"));
  EXPECT_EQ(copy_of(cannelloni::stream_frame_of(Frame::remote({0x100, true}, 2)).view()), hex("C0 00 01 00 02"));
  EXPECT_TRUE(cannelloni::stream_frame_of(Frame{{}, FrameKind::kError, 0, {}}).view().empty());
  EXPECT_TRUE(cannelloni::stream_frame_of(Frame::of(0x800, {})).view().empty());
}

TEST(CannelloniStream, FramesAreReadOneBehindTheOther) {
  using Event = cannelloni::StreamReader::Event;
  cannelloni::StreamReader reader;
  std::vector<Event> ends;
  std::vector<Frame> frames;
  for (const std::byte byte :
       hex("00 00 01 23 02 11 22  C0 00 01 00 02  00 00 01 23 8C 01 00 01 02 03 04 05 06 07 08 09 "
           "0A 0B  00 00 08 00 00  00 00 01 24 00")) {
    const Event event = reader.take(byte);
    if (event != Event::kMore) ends.push_back(event);
    if (event == Event::kFrame) frames.push_back(reader.frame());
  }
  EXPECT_EQ(ends,
            (std::vector<Event>{Event::kFrame, Event::kFrame, Event::kPassedOver, Event::kPassedOver, Event::kFrame}));
  EXPECT_EQ(frames, (std::vector<Frame>{Frame::of(0x123, hex("11 22")), Frame::remote({0x100, true}, 2),
                                        Frame::of(0x124, {})}));
}

TEST(CannelloniStream, ALengthThatNoFrameHasBreaksIt) {
  using Event = cannelloni::StreamReader::Event;
  for (const std::string_view start : {"00 00 01 23 09", "00 00 01 23 7F", "00 00 01 23 C1"}) {
    cannelloni::StreamReader reader;
    Event last = Event::kMore;
    for (const std::byte byte : hex(start)) last = reader.take(byte);
    EXPECT_EQ(last, Event::kBroken) << start;
    EXPECT_EQ(reader.take(std::byte{0}), Event::kBroken);
  }
}

// CAN232 manual, commands S and s; SJA1000 application note AN97076 has 001C for 500 kbit/s, which S6 is.
TEST(SlcanBitRate, CommandsMakeTheRate) {
  EXPECT_EQ(slcan::bit_rate_command(10'000).view(), "S0");
  EXPECT_EQ(slcan::bit_rate_command(500'000).view(), "S6");
  EXPECT_EQ(slcan::bit_rate_command(1'000'000).view(), "S8");
  for (const std::uint32_t rate : {200'000U, 400'000U, 40'000U, 25'000U}) {
    const auto command = slcan::bit_rate_command(rate);
    ASSERT_EQ(command.view().substr(0, 1), "s") << rate;
    EXPECT_EQ(slcan::bit_rate_of(static_cast<std::uint16_t>(hex_number(command.view().substr(1)).value())), rate);
  }
  for (const std::uint32_t rate : {0U, 1U, 333'333U, 3'000'000U, 0xFFFF'FFFFU})
    EXPECT_TRUE(slcan::bit_rate_command(rate).view().empty()) << rate;
}

}  // namespace
}  // namespace driveline::canopen
