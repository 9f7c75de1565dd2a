// Clients that speak cannelloni. Bytes by the tables of its doc/udp_format.md and doc/tcp_protocol.md.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "driveline/slaves/can/cannelloni_door.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::ElementsAre;
using namespace std::chrono_literals;

std::string text(std::string_view digits) {
  std::string out;
  for (const auto byte : hex(digits)) out += static_cast<char>(byte);
  return out;
}

template <typename Client>
class CannelloniTest : public ::testing::Test {
 protected:
  CannelloniTest() {
    bus.attach(node);
    bus.attach(door, {.error_frames = true, .automatic_recovery = true});
    door.open();
  }
  void say(std::string_view bytes) {
    door.input(bytes, bus.now());
    bus.advance(bus.now() + 1ms);
  }
  std::string take(std::size_t size) {
    const std::string out(door.output().substr(0, size));
    door.taken(size);
    return out;
  }

  Bus bus;
  ScriptedNode node;
  Client door;
};

using CannelloniUdp = CannelloniTest<CannelloniUdpDoor>;
using CannelloniTcp = CannelloniTest<CannelloniTcpDoor>;

TEST_F(CannelloniUdp, PacketsInBothDirections) {
  EXPECT_EQ(door.output(), "") << "nobody greets";
  say(text("02 00 07 00 03  00 00 01 00 02 11 33  9A AA AA AA 02 01 F1  40 00 07 0A 04"));
  EXPECT_THAT(node.identifiers(), ElementsAre(0x100, 0x1AAA'AAAA, 0x70A));
  EXPECT_EQ(node.received[2].frame, Frame::remote({0x70A, false}, 4));
  node.send_at(bus.now(), Frame::of(0x181, hex("AB CD")));
  node.send_at(bus.now(), Frame::remote({0x701, false}, 1));
  bus.advance(bus.now() + 5ms);
  EXPECT_EQ(take(door.piece()), text("02 00 00 00 02  00 00 01 81 02 AB CD  40 00 07 01 01"));
  EXPECT_EQ(door.output(), "");
  EXPECT_EQ(door.piece(), 0U);
  EXPECT_EQ(door.statistics().sent, 3U);
  EXPECT_EQ(door.statistics().received, 2U);
}

TEST_F(CannelloniUdp, APacketWaitsOneMillisecondForFurtherFrames) {
  node.send_at(1ms, Frame::of(0x181, hex("01")));
  node.send_at(1900us, Frame::of(0x182, hex("02")));
  bus.advance(2ms);
  EXPECT_EQ(door.output(), "");
  bus.advance(2500us);  // the first one has come with its last bit, 1 ms and some 60 us after the start
  EXPECT_EQ(take(door.piece()), text("02 00 00 00 02  00 00 01 81 01 01  00 00 01 82 01 02"));
  node.send_at(4ms, Frame::of(0x183, {}));
  bus.advance(6ms);
  EXPECT_EQ(take(door.piece()), text("02 00 01 00 01  00 00 01 83 00")) << "the next sequence number";
}

TEST_F(CannelloniUdp, APacketHasNoMoreBytesThanAnEthernetFrame) {
  for (int i = 0; i < 200; ++i) door.receive(Frame::of(0x181, hex("01 02 03 04 05 06 07 08")), bus.now());
  constexpr std::size_t kFrames = (1472 - 5) / 13;
  EXPECT_EQ(door.piece(), 5 + kFrames * 13);
  EXPECT_EQ(door.output().substr(3, 2), text("00 70")) << kFrames;
  EXPECT_EQ(door.output().size(), 5 + kFrames * 13) << "the second packet is not complete";
}

TEST_F(CannelloniUdp, GapsOfSequenceNumbersAreCounted) {
  for (const std::string_view sequence : {"FE", "FF", "00", "03", "02", "04"}) {
    say(text("02 00 " + std::string(sequence) + " 00 01  00 00 01 23 00"));
  }
  EXPECT_EQ(door.statistics().missing, 2U) << "01 and 02, which came late";
  EXPECT_EQ(node.received.size(), 6U) << "late ones are taken";
  door.leave();
  door.open();
  say(text("02 00 80 00 01  00 00 01 23 00"));
  EXPECT_EQ(door.statistics().missing, 2U) << "a new client begins anywhere";
}

TEST_F(CannelloniUdp, WhatIsNoPacketIsRefused) {
  for (const std::string_view packet : {"", "02 00 01 00", "01 00 01 00 00", "02 01 01 00 00"}) {
    EXPECT_FALSE(CannelloniUdpDoor::is_packet(text(packet))) << packet;
    say(text(packet));
  }
  EXPECT_EQ(door.statistics().refused, 4U);
  say(text("02 00 01 00 02  00 00 01 23 01 AA  00 00 01 24 09"));
  EXPECT_EQ(door.statistics().refused, 5U) << "the rest of a packet that is not complete";
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123));
  say(text("02 00 02 00 02  00 00 01 23 82 00 AA BB  20 00 00 80 08 00 00 00 00 00 00 00 00"));
  EXPECT_EQ(node.received.size(), 1U) << "CAN FD and error frames are left out";
}

TEST_F(CannelloniUdp, AFastClientIsSentAsFastAsTheBusTakesIt) {
  std::string packet = text("02 00 00 00 C8");
  for (int i = 0; i < 200; ++i) packet += text("00 00 01 23 01") + static_cast<char>(i);
  say(packet);
  bus.advance(bus.now() + 100ms);
  ASSERT_EQ(node.received.size(), 200U);
  for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(node.received[i].frame.data[0], static_cast<std::byte>(i));
  for (int i = 0; i < 10; ++i) door.input(packet, bus.now());
  EXPECT_EQ(door.statistics().refused, 2000U - 64 - CannelloniDoor::kBacklog);
}

TEST_F(CannelloniTcp, GreetingThenFramesInBothDirections) {
  EXPECT_EQ(take(door.output().size()), "CANNELLONIv1");
  node.send_at(0ms, Frame::of(0x180, {}));
  say("CANNELL");
  EXPECT_TRUE(node.sent.empty()) << "not on the bus yet";
  say("ONIv1" + text("00 00 01 00 02 11"));
  EXPECT_EQ(take(door.output().size()), text("00 00 01 80 00"));
  say(text("33  9A AA AA AA 02 01 F1  40 00 07 0A 04  00 00 01 23 82 00 AA BB"));
  EXPECT_THAT(node.identifiers(), ElementsAre(0x100, 0x1AAA'AAAA, 0x70A));
  EXPECT_EQ(node.received[0].frame, Frame::of(0x100, hex("11 33")));
  node.send_at(bus.now(), Frame::of(canopen::Identifier{0x1234567, true}, hex("AB CD")));
  node.send_at(bus.now(), Frame::remote({0x701, false}, 1));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(take(door.output().size()), text("81 23 45 67 02 AB CD  40 00 07 01 01"));
  EXPECT_FALSE(door.closing());
}

TEST_F(CannelloniTcp, AnotherGreetingEndsTheConnection) {
  say("CANNELLONIv2");
  EXPECT_TRUE(door.closing());
  EXPECT_EQ(door.statistics().refused, 1U);
  door.leave();
  door.open();
  EXPECT_EQ(door.output(), "CANNELLONIv1") << "the next client";
  say("CANNELLONIv1" + text("00 00 01 23 00"));
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123));
}

TEST_F(CannelloniTcp, ALengthThatNoFrameHasEndsTheConnection) {
  say("CANNELLONIv1" + text("00 00 01 23 00  00 00 01 24 09 01 02 03"));
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123));
  EXPECT_TRUE(door.closing());
  EXPECT_EQ(door.statistics().refused, 1U);
}

TEST_F(CannelloniTcp, AClientThatDoesNotReadLosesFrames) {
  say("CANNELLONIv1");
  for (int i = 0; i < 6000; ++i) node.send_at(bus.now() + i * 200us, Frame::of(0x7E3, hex("01 02 03 04 05 06 07 08")));
  bus.advance(bus.now() + 2s);
  EXPECT_LE(door.output().size(), Door::kOutputBytes);
  EXPECT_GT(door.statistics().dropped, 100U);
  EXPECT_EQ(door.statistics().dropped + door.statistics().received, 6000U);
}

}  // namespace
}  // namespace driveline::slaves::can
