#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "driveline/slaves/can/slcan_door.hpp"
#include "driveline/slaves/can/socketcand_door.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::ElementsAre;
using namespace std::chrono_literals;

/// A node at 500 kbit/s and the doors of some clients, which have the same bit rate.
class DoorTest : public ::testing::Test {
 protected:
  DoorTest() { bus.attach(node, {.bit_rate = 500'000}); }

  void attach(Door& door) {
    bus.attach(door, {.bit_rate = 500'000});
    door.open();
  }

  /// What the client gets for these bytes and in the next millisecond.
  std::string say(Door& door, std::string_view bytes) {
    door.input(bytes, bus.now());
    bus.advance(bus.now() + 1ms);
    return take(door);
  }
  static std::string take(Door& door) {
    std::string text(door.output());
    door.taken(text.size());
    return text;
  }

  Bus bus;
  ScriptedNode node;
};

class SlcanDoorTest : public DoorTest {
 protected:
  SlcanDoorTest() { attach(door); }
  SlcanDoor door;
};

TEST_F(SlcanDoorTest, AClosedChannelIsNotOnTheBus) {
  EXPECT_EQ(say(door, "t1230\r"), "\a");
  node.send_at(bus.now() + 1us, Frame::of(0x345, hex("11")));
  bus.advance(bus.now() + 1ms);
  EXPECT_TRUE(node.sent.empty()) << "nobody acknowledges";
  EXPECT_EQ(door.output(), "");
  EXPECT_EQ(door.statistics().refused, 1U);
  EXPECT_EQ(say(door, "O\r"), "\rt345111\r") << "the frame was still waiting";
  EXPECT_EQ(say(door, "C\r"), "\r");
  node.send_at(bus.now() + 1us, Frame::of(0x346, hex("22")));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(node.sent.size(), 1U);
  EXPECT_EQ(door.output(), "");
}

TEST_F(SlcanDoorTest, FramesInBothDirections) {
  EXPECT_EQ(say(door, "O\r"), "\r");
  EXPECT_EQ(say(door, "t60284340100000000000F\rT1AAAAAAA201F1\rr70A4\r"), "\aZ\rz\r")
      << "the first has more digits than bytes";
  EXPECT_THAT(node.identifiers(), ElementsAre(0x1AAA'AAAA, 0x70A));
  EXPECT_EQ(node.received[1].frame, Frame::remote({0x70A, false}, 4));
  node.send_at(bus.now(), Frame::of(0x582, hex("43 00 10 00 92 01 02 00")));
  node.send_at(bus.now(), Frame::remote({0x1234567, true}, 3));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(take(door), "R012345673\rt58284300100092010200\r");
  EXPECT_EQ(door.statistics().sent, 2U);
  EXPECT_EQ(door.statistics().received, 2U);
}

TEST_F(SlcanDoorTest, BitRateTimeStampsAndModeAreSetWhileTheChannelIsClosed) {
  EXPECT_EQ(say(door, "S6\rs001C\rZ1\rL\r"), "\r\r\r\r");
  for (const std::string_view command : {"S6\r", "s001C\r", "Z0\r", "O\r", "L\r"})
    EXPECT_EQ(say(door, command), "\a") << command;
  EXPECT_EQ(say(door, "C\rC\r"), "\r\a");
  for (const std::string_view command :
       {"S9\r", "S\r", "S66\r", "s0000\r", "s1\r", "Z2\r", "Z\r", "X0\r", "P\r", "O1\r", "\x80\r"}) {
    EXPECT_EQ(say(door, command), "\a") << command;
  }
}

TEST_F(SlcanDoorTest, TimeStampsAreMillisecondsOfAMinute) {
  EXPECT_EQ(say(door, "Z1\rO\r"), "\r\r");
  node.send_at(61'003ms, Frame::of(0x123, hex("AB")));
  bus.advance(62s);
  EXPECT_EQ(take(door), "t1231AB03EB\r");
}

TEST_F(SlcanDoorTest, AListenerReceivesAndDoesNotSend) {
  SlcanDoor other;
  attach(other);
  EXPECT_EQ(say(other, "O\r"), "\r");
  EXPECT_EQ(say(door, "L\r"), "\r");
  EXPECT_EQ(say(door, "t1230\r"), "\a");
  EXPECT_EQ(say(other, "t1231AA\r"), "z\r");
  EXPECT_EQ(take(door), "t1231AA\r");
  EXPECT_EQ(say(door, "C\rO\rt1241BB\r"), "\r\rz\r") << "and sends when it is opened as a node";
}

TEST_F(SlcanDoorTest, AnotherBitRateIsAnErrorOnTheBus) {
  EXPECT_EQ(say(door, "S5\rO\rt1230\r"), "\r\rz\r");
  bus.advance(bus.now() + 50ms);
  EXPECT_TRUE(node.received.empty());
  EXPECT_EQ(say(door, "F\r").substr(0, 1), "F");
  EXPECT_GT(bus.statistics().error_frames, 0U);
}

TEST_F(SlcanDoorTest, TwoClientsTakePartInArbitration) {
  SlcanDoor other;
  attach(other);
  say(door, "O\r");
  say(other, "O\r");
  door.input("t3001AA\r", bus.now());
  other.input("t2001BB\r", bus.now());
  bus.advance(bus.now() + 1ms);
  EXPECT_THAT(node.identifiers(), ElementsAre(0x200, 0x300));
  EXPECT_EQ(take(door), "z\rt2001BB\r");
  EXPECT_EQ(take(other), "z\rt3001AA\r");
}

TEST_F(SlcanDoorTest, StatusFlagsTellOfFramesThatTheClientLost) {
  say(door, "O\r");
  EXPECT_EQ(say(door, "F\r"), "F00\r");
  for (int i = 0; i < 5000; ++i) node.send_at(bus.now() + i * 300us, Frame::of(0x7E3, hex("01 02 03 04 05 06 07 08")));
  bus.advance(bus.now() + 2s);
  EXPECT_GT(door.statistics().dropped, 100U);
  EXPECT_LE(door.output().size(), Door::kOutputBytes);
  EXPECT_EQ(door.statistics().dropped + door.statistics().received, 5000U);
  take(door);
  EXPECT_EQ(say(door, "F\r"), "F08\r");
  EXPECT_EQ(say(door, "F\r"), "F00\r");
}

TEST_F(SlcanDoorTest, LinesInPiecesAndLinesThatNeverEnd) {
  EXPECT_EQ(say(door, "\r\r\r"), "\r\r\r");
  EXPECT_EQ(say(door, "O"), "");
  EXPECT_EQ(say(door, "\r\nV\r\nN\r"), "\rV1013\rNDRVL\r");
  EXPECT_EQ(say(door, std::string(1 << 20, 't')), "");
  EXPECT_EQ(say(door, "\rt12"), "\a");
  EXPECT_EQ(say(door, "30\r"), "z\r");
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123));
}

TEST_F(SlcanDoorTest, TheNextClientFindsANewAdapter) {
  say(door, "S5\rZ1\rL\rt12");
  door.leave();
  door.open();
  EXPECT_EQ(say(door, "t1230\r"), "\a") << "closed";
  EXPECT_EQ(say(door, "O\rt1241BB\r"), "\rz\r") << "at the bit rate of the bus, and not as a listener";
  node.send_at(bus.now(), Frame::of(0x345, hex("11")));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(take(door), "t345111\r") << "without time stamps";
  EXPECT_THAT(node.identifiers(), ElementsAre(0x124));
  EXPECT_EQ(door.statistics().refused, 1U);
}

class SocketcandDoorTest : public DoorTest {
 protected:
  SocketcandDoorTest() { attach(door); }
  SocketcandDoor door{"can0", 1'436'509'052s};
};

TEST_F(SocketcandDoorTest, RawModeInBothDirections) {
  EXPECT_EQ(say(door, ""), "< hi >");
  EXPECT_EQ(say(door, "< open can0 >"), "< ok >");
  EXPECT_EQ(say(door, "< rawmode >"), "< ok >");
  EXPECT_EQ(say(door, "< send 602 3 40 8 A0 >< sendrtr 70A 2 >"), "");
  EXPECT_THAT(node.identifiers(), ElementsAre(0x602, 0x70A));
  EXPECT_EQ(node.received[0].frame, Frame::of(0x602, hex("40 08 A0")));
  node.send_at(1s, Frame::of(0x582, hex("43 00")));
  node.send_at(2s, Frame::remote({0x701, false}, 1));
  bus.advance(3s);
  const auto text = take(door);
  EXPECT_TRUE(text.starts_with("< frame 582 1436509053.000")) << text;
  EXPECT_NE(text.find(" 4300 >< rtr 701 1436509054.000"), std::string::npos) << text;
}

TEST_F(SocketcandDoorTest, WithoutRawModeNothingIsToldOfFrames) {
  say(door, "< open can0 >");
  node.send_at(bus.now(), Frame::of(0x582, hex("43 00")));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(take(door), "");
  EXPECT_EQ(node.sent.size(), 1U) << "but the client is a node that acknowledges";
  EXPECT_EQ(say(door, "< rawmode >< bcmmode >"), "< ok >< ok >");
  node.send_at(bus.now(), Frame::of(0x582, hex("43 00")));
  bus.advance(bus.now() + 1ms);
  EXPECT_EQ(take(door), "");
}

TEST_F(SocketcandDoorTest, CommandsOutOfOrder) {
  take(door);
  EXPECT_EQ(say(door, "< rawmode >"), "< error no bus is open >");
  EXPECT_EQ(say(door, "< send 123 0 >"), "< error no bus is open >");
  EXPECT_EQ(say(door, "<echo>"), "< echo >");
  EXPECT_EQ(say(door, "< open can0 >< open can0 >"), "< ok >< error a bus is open already >");
  EXPECT_EQ(say(door, "< muxfilter 0 0 123 0 >"), "< error unknown command >");
  EXPECT_EQ(say(door, "< isotpmode >"), "< error ISO-TP is not supported >");
  EXPECT_EQ(say(door, "< send 123 9 >"), "< error syntax error in send command >");
  EXPECT_EQ(say(door, "<>noise< echo > send 123 0 >"), "< error unknown command >< echo >");
  EXPECT_EQ(say(door, "< send 123 2 11 22" + std::string(1 << 20, ' ')), "< error command too long >");
  EXPECT_EQ(say(door, ">< send 123 2 11 22 >"), "");
  EXPECT_THAT(node.identifiers(), ElementsAre(0x123));
  EXPECT_FALSE(door.closing());
}

TEST_F(SocketcandDoorTest, AClientOfAnotherBusIsSentAway) {
  take(door);
  EXPECT_EQ(say(door, "< open can1 >< open can0 >"), "< error could not open bus >");
  EXPECT_TRUE(door.closing());
}

/// Whatever clients send, the bus goes on and a new client gets its answers.
TEST_F(DoorTest, AnyBytesLeaveABusThatWorks) {
  std::mt19937 random(20261130);
  const std::string_view letters = "tTrRSsOLCFVNZXP0123456789ABCDEF\r\a\n<> opensdrawmodcan0\x80";
  for (int round = 0; round < 20; ++round) {
    SlcanDoor serial;
    SocketcandDoor daemon{"can0"};
    Bus line;
    ScriptedNode other;
    for (Node* one : std::initializer_list<Node*>{&serial, &daemon, &other}) line.attach(*one, {.bit_rate = 500'000});
    serial.open();
    daemon.open();
    for (int i = 0; i < 2000; ++i) {
      const char letter = letters[random() % letters.size()];
      serial.input({&letter, 1}, line.now());
      daemon.input({&letter, 1}, line.now());
      line.advance(line.now() + 100us);
    }
    EXPECT_LE(serial.output().size(), Door::kOutputBytes);
    SlcanDoor fresh;
    line.attach(fresh, {.bit_rate = 500'000});
    fresh.open();
    serial.input("\rC\r", line.now());
    line.advance(line.now() + 100ms);
    fresh.input("O\rt3211AA\r", line.now());
    EXPECT_EQ(take(fresh), "\rz\r");
    line.advance(line.now() + 100ms);
    ASSERT_FALSE(other.received.empty());
    EXPECT_EQ(other.received.back().frame, Frame::of(0x321, hex("AA")));
  }
}

}  // namespace
}  // namespace driveline::slaves::can
