#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "driveline/canopen_wire/frame_bits.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

/// Three nodes at 250 kbit/s: a bit takes 4 us.
class CanFaultTest : public ::testing::Test {
 protected:
  CanFaultTest() {
    for (ScriptedNode& one : node) bus.attach(one, {.bit_rate = 250'000});
  }
  void send(std::size_t from, std::uint32_t identifier, nanoseconds time) {
    node.at(from).send_at(time, Frame::of(identifier, hex("0A 0B")));
  }
  [[nodiscard]] const ErrorCounters& errors(std::size_t of) { return node.at(of).controller().errors(); }

  Bus bus;
  std::array<ScriptedNode, 3> node;
};

// C6: alone on the bus: TEC + 8 per try up to error passive, then no further.
TEST(LonelyNode, C6IsErrorPassiveAndNeverBusOff) {
  Bus bus;
  ScriptedNode alone;
  bus.attach(alone, {.bit_rate = 250'000});
  alone.send_at(5us, Frame::of(0x123, hex("0A 0B")));
  bus.advance(500us);
  EXPECT_EQ(alone.controller().errors().transmit(), 8U);
  bus.advance(100ms);
  EXPECT_EQ(alone.controller().errors().transmit(), 128U);
  EXPECT_THAT(alone.states, ElementsAre(ErrorState::kPassive));
  EXPECT_THAT(alone.sent, IsEmpty());
  EXPECT_GT(bus.statistics().error_frames, 100U);
}

TEST(LonelyNode, C6SendsAsSoonAsSomebodyAcknowledges) {
  Bus bus;
  ScriptedNode alone;
  ScriptedNode other;
  bus.attach(alone);
  bus.attach(other).set_power(false);
  alone.send_at(5us, Frame::of(0x123, hex("0A 0B")));
  bus.advance(10ms);
  EXPECT_THAT(alone.sent, IsEmpty());
  other.controller().set_power(true);
  bus.advance(20ms);
  EXPECT_EQ(alone.sent.size(), 1U);
  EXPECT_THAT(other.identifiers(), ElementsAre(0x123));
  EXPECT_EQ(alone.controller().errors().transmit(), 127U);  // C10
}

// C9: listen-only disturbs nobody and acknowledges nothing.
TEST(LonelyNode, C9AListenerDoesNotAcknowledge) {
  Bus bus;
  ScriptedNode alone;
  ScriptedNode listener;
  bus.attach(alone);
  bus.attach(listener, {.listen_only = true, .error_frames = true});
  alone.send_at(5us, Frame::of(0x123, {}));
  listener.send_at(5us, Frame::of(0x001, {}));
  bus.advance(1ms);
  EXPECT_THAT(alone.sent, IsEmpty());
  EXPECT_EQ(listener.accepted, 0U);
  ASSERT_FALSE(listener.received.empty());
  EXPECT_EQ(listener.received[0].frame.kind, canopen::FrameKind::kError);  // C1: error frames
}

// C7: the same identifier with different data from two nodes: both count, until one is bus off.
TEST_F(CanFaultTest, C7ADuplicateIdentifierEndsInBusOff) {
  for (int i = 0; i < 60; ++i) {
    node[0].send_at(i * 10ms, Frame::of(0x705, hex("05")));
    node[1].send_at(i * 10ms, Frame::of(0x705, hex("7F")));
  }
  bus.advance(300us);
  EXPECT_EQ(errors(0).transmit(), 8U);
  EXPECT_EQ(errors(1).transmit(), 8U);
  EXPECT_EQ(errors(2).receive(), 1U);
  bus.advance(599ms);
  // 05h has the dominant bit: it gets through when the other one's flags are passive, which fails once in each round
  // and is sent alone behind it.
  EXPECT_EQ(errors(1).state(), ErrorState::kBusOff);
  EXPECT_THAT(node[1].states, ElementsAre(ErrorState::kPassive, ErrorState::kBusOff));
  EXPECT_NE(errors(0).state(), ErrorState::kBusOff);
  ASSERT_FALSE(node[2].received.empty());
  EXPECT_EQ(node[2].received.front().frame, Frame::of(0x705, hex("05")));
  EXPECT_EQ(node[2].received.back().frame, Frame::of(0x705, hex("05")));
  EXPECT_EQ(node[0].sent.size(), 60U);
  EXPECT_LT(node[1].sent.size(), 25U);
}

// C8: in bus off nothing is sent or received; back after 128 x 11 recessive bits when it is asked for.
TEST_F(CanFaultTest, C8BusOffAndRecovery) {
  bus.inject({.identifier = 0x0D2, .mask = 0x7FF, .count = 1000});
  send(0, 0x0D2, 10us);
  bus.advance(30ms);
  ASSERT_EQ(errors(0).state(), ErrorState::kBusOff);
  EXPECT_EQ(bus.statistics().error_frames, 32U);  // 32 x 8 = 256
  send(0, 0x0D3, 30ms + 1us);
  send(1, 0x0D4, 31ms);
  bus.advance(40ms);
  EXPECT_EQ(node[0].accepted, 1U);
  EXPECT_THAT(node[0].received, IsEmpty());
  EXPECT_EQ(errors(0).state(), ErrorState::kBusOff);  // never by itself
  node[0].controller().recover(bus.now());
  constexpr nanoseconds kRecovery = 128 * 11 * 4us;
  bus.advance(40ms + kRecovery - 1ns);
  EXPECT_EQ(errors(0).state(), ErrorState::kBusOff);
  bus.advance(40ms + kRecovery);
  EXPECT_EQ(errors(0).state(), ErrorState::kActive);
  EXPECT_EQ(errors(0).transmit(), 0U);
  EXPECT_EQ(node[0].states.back(), ErrorState::kActive);
  send(1, 0x0D5, 50ms);
  bus.advance(60ms);
  EXPECT_THAT(node[0].identifiers(), ElementsAre(0x0D5));
}

TEST_F(CanFaultTest, C8OnABusyBusEachFrameEndsWithElevenRecessiveBits) {
  bus.inject({.identifier = 0x0D2, .mask = 0x7FF, .count = 32});
  ScriptedNode fast;
  bus.attach(fast, {.bit_rate = 250'000, .automatic_recovery = true});
  fast.send_at(10us, Frame::of(0x0D2, hex("0A 0B")));
  bus.advance(20ms);
  ASSERT_EQ(fast.controller().errors().state(), ErrorState::kActive);  // 5.6 ms of an idle bus
  bus.inject({.identifier = 0x0D2, .mask = 0x7FF, .count = 32});
  fast.send_at(30ms, Frame::of(0x0D2, hex("0A 0B")));
  node[0].controller().babble(Frame::of(0x7FF, hex("55 55 55 55 55 55 55 55")));
  bus.advance(30ms + 40ms);
  const auto states = fast.states;
  ASSERT_EQ(states.back(), ErrorState::kBusOff);  // 128 frames of more than 110 bits: 56 ms
  bus.advance(30ms + 90ms);
  EXPECT_EQ(fast.controller().errors().state(), ErrorState::kActive);
}

// C9: another bit rate on the same wire.
TEST_F(CanFaultTest, C9ANodeWithAnotherBitRateDestroysFramesUntilItIsPassive) {
  ScriptedNode stranger;
  bus.attach(stranger, {.bit_rate = 125'000});
  for (int i = 0; i < 20; ++i) send(0, 0x200U + static_cast<unsigned>(i), i * 5ms);
  bus.advance(300us);
  EXPECT_GT(errors(0).transmit(), 0U);
  EXPECT_THAT(node[1].received, IsEmpty());
  bus.advance(200ms);
  EXPECT_EQ(stranger.controller().errors().state(), ErrorState::kPassive);
  EXPECT_THAT(stranger.received, IsEmpty());
  EXPECT_EQ(node[1].received.size(), 20U);
  EXPECT_EQ(bus.statistics().error_frames, 15U);  // of nine receive errors each
}

TEST_F(CanFaultTest, C9ItsOwnFramesAreErrorsToAllAndLeadToBusOff) {
  ScriptedNode stranger;
  bus.attach(stranger, {.bit_rate = 125'000});
  stranger.send_at(5us, Frame::of(0x111, {}));
  bus.advance(100ms);
  EXPECT_EQ(stranger.controller().errors().state(), ErrorState::kBusOff);
  EXPECT_THAT(node[0].received, IsEmpty());
  EXPECT_GT(errors(0).receive(), 0U);
}

TEST_F(CanFaultTest, C9AListenerWithAnotherBitRateDisturbsNobody) {
  ScriptedNode stranger;
  bus.attach(stranger, {.bit_rate = 125'000, .listen_only = true});
  send(0, 0x200, 5us);
  bus.advance(2ms);
  EXPECT_EQ(node[1].received.size(), 1U);
  EXPECT_EQ(bus.statistics().error_frames, 0U);
  EXPECT_THAT(stranger.received, IsEmpty());
}

// C11: a frame that is lost is acknowledged, so that nobody sends it again.
TEST_F(CanFaultTest, C11ALostFrame) {
  bus.inject({.kind = FrameFaultKind::kLost, .identifier = 0x185, .mask = 0x7FF, .count = 1, .receiver = 2});
  send(0, 0x184, 5us);
  send(0, 0x185, 1ms);
  send(0, 0x185, 2ms);
  bus.advance(5ms);
  EXPECT_THAT(node[1].identifiers(), ElementsAre(0x184, 0x185, 0x185));
  EXPECT_THAT(node[2].identifiers(), ElementsAre(0x184, 0x185));
  EXPECT_EQ(node[0].sent.size(), 3U);
  EXPECT_EQ(bus.statistics().lost, 1U);
}

// C11: a bit error ends the frame for all; it is repeated.
TEST_F(CanFaultTest, C11ABitError) {
  ScriptedNode listener;
  bus.attach(listener, {.bit_rate = 250'000, .listen_only = true, .error_frames = true});
  bus.inject({.identifier = 0x2A5, .mask = 0x7FF, .count = 2, .bit = 25});
  send(0, 0x2A5, 8us);
  bus.advance(10ms);
  EXPECT_EQ(node[1].received.size(), 1U);
  EXPECT_EQ(errors(0).transmit(), 8U + 8U - 1U);  // C10
  EXPECT_EQ(errors(1).receive(), 1U + 1U - 1U);
  ASSERT_EQ(listener.received.size(), 3U);
  EXPECT_EQ(listener.received[0].frame.kind, canopen::FrameKind::kError);
  // 26 bits with two stuff bits among them, error flags of 12 bits and a delimiter of 8, at 4 us each. The five zeros
  // are those of 000 00 and of 0 0000: 0 01010100101 0 0 0 0010 00001010.
  EXPECT_EQ(listener.received[0].time, 8us + (26 + 2 + 20) * 4us);
}

// C11: a babbling node with the best identifier leaves the others no room.
TEST_F(CanFaultTest, C11ABabblingNode) {
  send(0, 0x200, 1ms);
  node[2].controller().babble(Frame::of(0x001, hex("EE")));
  bus.advance(20ms);
  EXPECT_THAT(node[0].sent, IsEmpty());
  EXPECT_GT(node[1].received.size(), 60U);
  EXPECT_THAT(node[1].identifiers(), Each(0x001));
  node[2].controller().babble(std::nullopt);
  bus.advance(21ms);
  EXPECT_EQ(node[0].sent.size(), 1U);
}

// C11: the wire is cut: each piece is a bus of its own.
TEST_F(CanFaultTest, C11ACutWire) {
  bus.cut(1);
  send(0, 0x200, 1ms);
  send(2, 0x300, 2ms);
  bus.set_wiring({.length_m = 10});
  bus.advance(2900us);
  EXPECT_THAT(node[2].received, IsEmpty());
  EXPECT_THAT(node[2].sent, IsEmpty());  // nobody acknowledges
  EXPECT_GT(errors(2).transmit(), 0U);
  bus.mend(1);
  bus.advance(20ms);
  EXPECT_THAT(node[2].sent, ::testing::SizeIs(1));
  EXPECT_THAT(node[0].identifiers(), ElementsAre(0x300));
}

TEST_F(CanFaultTest, C11AFrameUnderWayEndsInAnErrorWhenTheWireIsCut) {
  send(0, 0x200, 1ms);
  bus.advance(1ms + 100us);
  bus.cut(1);
  bus.advance(1ms + 101us);
  EXPECT_EQ(errors(0).transmit(), 8U);
  EXPECT_EQ(errors(2).receive(), 1U);
}

// C11: a missing terminator: errors above a bit rate.
TEST(CanTerminator, C11WithoutOneAFastBusHasErrors) {
  const auto errors_at = [](std::uint32_t bit_rate, const Wiring& wiring) {
    Bus bus(wiring, 3);
    std::array<ScriptedNode, 2> nodes;
    for (auto& one : nodes) bus.attach(one, {.bit_rate = bit_rate});
    for (int i = 0; i < 10; ++i) nodes[0].send_at(i * 100ms, Frame::of(0x123, hex("0A")));
    bus.advance(2000ms);
    return bus.statistics().error_frames;
  };
  const Wiring one{.length_m = 20, .first_terminated = false};
  const Wiring none{.length_m = 20, .first_terminated = false, .last_terminated = false};
  EXPECT_EQ(errors_at(1'000'000, {.length_m = 20}), 0U);
  EXPECT_EQ(errors_at(125'000, one), 0U);
  EXPECT_GT(errors_at(250'000, one), 0U);
  EXPECT_GT(errors_at(125'000, none), 0U);
  EXPECT_EQ(errors_at(20'000, none), 0U);
  EXPECT_EQ(errors_at(500'000, {.length_m = 100}), 0U);
  EXPECT_GT(errors_at(500'000, {.length_m = 101}), 0U);  // the cable is too long
}

// C11: a node that holds the bus dominant stops it; the others count errors and survive.
TEST_F(CanFaultTest, C11StuckDominant) {
  bus.advance(1ms);
  node[2].controller().hold_dominant(true);
  send(0, 0x200, 2ms);
  bus.advance(50ms);
  EXPECT_THAT(node[1].received, IsEmpty());
  EXPECT_EQ(errors(1).state(), ErrorState::kPassive);
  EXPECT_EQ(errors(0).state(), ErrorState::kPassive);
  node[2].controller().hold_dominant(false);
  bus.advance(60ms);
  EXPECT_THAT(node[1].identifiers(), ElementsAre(0x200));
}

// C11: a node without power is not there.
TEST_F(CanFaultTest, C11ANodeWithoutPower) {
  node[2].controller().set_power(false);
  send(0, 0x200, 1ms);
  send(2, 0x300, 2ms);
  bus.advance(10ms);
  EXPECT_EQ(node[1].identifiers(), (std::vector<std::uint32_t>{0x200}));
  EXPECT_THAT(node[2].received, IsEmpty());
  EXPECT_EQ(node[2].accepted, 0U);
}

TEST_F(CanFaultTest, C11PowerThatGoesAndComesWithinAFrameLosesIt) {
  send(0, 0x200, 1ms);
  bus.advance(1ms + 40us);
  node[0].controller().set_power(false);
  node[0].controller().set_power(true);
  bus.advance(10ms);
  EXPECT_THAT(node[1].received, IsEmpty());
  EXPECT_THAT(node[0].sent, IsEmpty());
  EXPECT_EQ(errors(1).receive(), 1U);
}

}  // namespace
}  // namespace driveline::slaves::can
