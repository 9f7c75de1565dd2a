#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "driveline/canopen_wire/frame_bits.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::ElementsAre;
using namespace std::chrono_literals;

/// Three nodes at 500 kbit/s: a bit takes 2 us.
class CanBusTest : public ::testing::Test {
 protected:
  static constexpr nanoseconds kBit{2000};
  static nanoseconds bits(std::size_t count) { return static_cast<std::int64_t>(count) * kBit; }

  CanBusTest() {
    for (ScriptedNode& one : node) bus.attach(one, {.bit_rate = 500'000});
  }

  Bus bus;
  std::array<ScriptedNode, 3> node;
};

// C5: everybody but the sender. C2: the time on the wire is that of the bits.
TEST_F(CanBusTest, C5OthersReceiveWhenTheLastBitHasPassed) {
  const Frame frame = Frame::of(0x1A5, hex("11 22 33"));
  node[1].send_at(7us, frame);
  bus.advance(1ms);
  const nanoseconds end = 7us + bits(canopen::bit_count(frame) - 3);
  EXPECT_THAT(node[0].received, ElementsAre(ScriptedNode::Seen{end, frame}));
  EXPECT_EQ(node[2].received, node[0].received);
  EXPECT_TRUE(node[1].received.empty());
  EXPECT_EQ(node[1].sent, node[0].received);
  EXPECT_EQ(bus.statistics().frames, 1U);
  EXPECT_EQ(bus.statistics().busy, bits(canopen::bit_count(frame)));
}

TEST_F(CanBusTest, C5LoopBackOnlyWhereAskedFor) {
  ScriptedNode own;
  bus.attach(own, {.bit_rate = 500'000, .loop_back = true});
  own.send_at(3us, Frame::of(0x123, {}));
  bus.advance(1ms);
  EXPECT_THAT(own.identifiers(), ElementsAre(0x123));
}

// C3: the lowest identifier of all that wait; C4: losers try again by themselves.
TEST_F(CanBusTest, C3TheLowestIdentifierGoesFirst) {
  node[0].send_at(10us, Frame::of(0x300, {}));
  node[1].send_at(10us, Frame::of(0x200, {}));
  node[1].send_at(10us, Frame::remote({0x200, false}, 0));
  node[2].send_at(10us, Frame::of(0x100 << 18 | 5, {}));
  node[2].send_at(10us, Frame::of(canopen::Identifier{0x200 << 18, true}, {}));
  ScriptedNode listener;
  bus.attach(listener, {.bit_rate = 500'000, .listen_only = true});
  bus.advance(5ms);
  std::vector<std::pair<std::uint32_t, bool>> order;
  for (const auto& seen : listener.received) {
    order.emplace_back(seen.frame.identifier.value, seen.frame.kind == canopen::FrameKind::kRemote);
  }
  EXPECT_THAT(order, ElementsAre(std::pair{0x200U, false}, std::pair{0x200U, true}, std::pair{0x200U << 18, false},
                                 std::pair{0x300U, false}));
  EXPECT_EQ(node[2].accepted, 1U);  // the identifier with too many bits is none
}

// C3: a frame that has begun is never interrupted.
TEST_F(CanBusTest, C3AFrameThatHasBegunIsNotInterrupted) {
  const Frame slow = Frame::of(0x700, hex("01 02 03 04 05 06 07 08"));
  node[0].send_at(10us, slow);
  node[1].send_at(12us, Frame::of(0x001, {}));
  bus.advance(2ms);
  EXPECT_THAT(node[2].identifiers(), ElementsAre(0x700, 0x001));
  // The next one starts behind the interframe space.
  EXPECT_EQ(node[2].received[1].time,
            10us + bits(canopen::bit_count(slow) + canopen::bit_count(Frame::of(0x001, {})) - 3));
}

// C4: a frame of low priority that waits does not stand in front of the same node's SYNC.
TEST_F(CanBusTest, C4ABetterFrameOfTheSameNodeOvertakes) {
  node[0].send_at(10us, Frame::of(0x100, hex("01 02 03 04 05 06 07 08")));
  node[1].send_at(12us, Frame::of(0x583, {}));
  node[1].send_at(20us, Frame::of(0x080, {}));
  bus.advance(2ms);
  EXPECT_THAT(node[2].identifiers(), ElementsAre(0x100, 0x080, 0x583));
}

TEST_F(CanBusTest, AFrameOnTheWireIsNotMixedUpWithABetterOneThatIsQueuedMeanwhile) {
  node[0].send_at(10us, Frame::of(0x583, hex("09")));
  node[0].send_at(14us, Frame::of(0x080, {}));
  bus.advance(2ms);
  EXPECT_THAT(node[2].identifiers(), ElementsAre(0x583, 0x080));
  EXPECT_EQ(node[0].sent.size(), 2U);
}

TEST_F(CanBusTest, EqualFramesOfTwoNodesAreOneFrame) {
  const Frame frame = Frame::of(0x0AB, hex("77"));
  node[0].send_at(10us, frame);
  node[1].send_at(10us, frame);
  bus.advance(1ms);
  EXPECT_EQ(node[2].received.size(), 1U);
  EXPECT_EQ(node[0].sent.size(), 1U);
  EXPECT_EQ(node[1].sent.size(), 1U);
}

// C2 and "bus load as measured equals the arithmetic": random traffic of three nodes, back to back.
TEST_F(CanBusTest, C2TheLoadOfABusyBusIsTheSumOfItsBits) {
  std::mt19937 random(4);
  std::size_t sum = 0;
  for (int i = 0; i < 60; ++i) {
    auto payload = hex("00 FF 00 FF 55 AA 12 34");
    payload.resize(random() % 9);
    const Frame frame = Frame::of(static_cast<std::uint32_t>(i * 3 + 1), payload);
    sum += canopen::bit_count(frame);
    node.at(static_cast<std::size_t>(i) % 3).send_at(0us, frame);
  }
  bus.advance(50ms);
  EXPECT_EQ(bus.statistics().frames, 60U);
  EXPECT_EQ(bus.statistics().busy, bits(sum));
  EXPECT_EQ(node[0].received.size(), 40U);
}

TEST_F(CanBusTest, TheSameSeedGivesTheSameBytesAtTheSameNanoseconds) {
  const auto run = [](std::uint64_t seed, nanoseconds step) {
    Bus line({.length_m = 30, .first_terminated = true, .last_terminated = false}, seed);
    std::array<ScriptedNode, 3> nodes;
    for (auto& one : nodes) line.attach(one, {.bit_rate = 500'000, .automatic_recovery = true});
    for (int i = 0; i < 200; ++i) {
      nodes.at(static_cast<std::size_t>(i) % 3)
          .send_at(i * 97us, Frame::of(static_cast<std::uint32_t>(900 - i), hex("12 34")));
    }
    for (nanoseconds now{0}; now < 60ms; now += step) line.advance(now);
    return nodes[0].received;
  };
  const auto seen = run(7, 1ms);
  EXPECT_GT(seen.size(), 50U);
  EXPECT_EQ(run(7, 1ms), seen);
  EXPECT_EQ(run(7, 13us), seen);  // however time is advanced
  EXPECT_NE(run(8, 1ms), seen);
}

}  // namespace
}  // namespace driveline::slaves::can
