// Faults of a bus by time: each kind begins, has its effect and ends; the same plan gives the same frames.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/slaves/can/bus_faults.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::can {
namespace {

using bytes_test::hex;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

/// Three nodes at 1 Mbit/s; the first one sends a frame each millisecond.
class BusFaultsTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 40;

  BusFaultsTest() {
    for (auto& node : nodes) bus.attach(node, {.automatic_recovery = true});
    for (int i = 0; i < kFrames; ++i)
      nodes[0].send_at(i * 1ms, Frame::of(0x181, std::array{static_cast<std::byte>(i)}));
    std::vector<std::function<void()>> restarts;
    for (std::size_t i = 0; i < nodes.size(); ++i) restarts.emplace_back([this, i] { restarted.push_back(i); });
    faults.emplace(bus, restarts);
  }
  void run(nanoseconds until) {
    for (; faults->next_event() <= until; faults->advance(bus.now())) bus.advance(faults->next_event());
    bus.advance(until);
    faults->advance(bus.now());
  }
  /// The numbers of the frames that a node has received.
  [[nodiscard]] std::vector<int> taken(std::size_t node) const {
    std::vector<int> numbers;
    for (const auto& one : nodes[node].received) {
      if (one.frame.identifier.value == 0x181) numbers.push_back(std::to_integer<int>(one.frame.data[0]));
    }
    return numbers;
  }
  /// How many of them are missing.
  [[nodiscard]] std::size_t missing(std::size_t node) const { return kFrames - taken(node).size(); }

  Bus bus;
  std::array<ScriptedNode, 3> nodes;
  std::vector<std::size_t> restarted;
  std::optional<BusFaults> faults;
};

TEST_F(BusFaultsTest, DropsOfOneSlaveAndOfAll) {
  faults->plan(2500us, {.kind = BusFaultKind::kDrop, .slave = 1, .count = 3});
  faults->plan(10500us, {.kind = BusFaultKind::kDrop, .duration = 4ms});
  run(60ms);
  EXPECT_EQ(missing(2), 4U);
  EXPECT_EQ(missing(1), 7U);
  const auto numbers = taken(1);
  EXPECT_EQ(std::count(numbers.begin(), numbers.end(), 3), 0);
  EXPECT_EQ(std::count(numbers.begin(), numbers.end(), 6), 1);
  EXPECT_THAT(faults->active(), IsEmpty()) << "the first one is used up";
}

TEST_F(BusFaultsTest, TwoDropsAtATime) {
  faults->plan(500us, {.kind = BusFaultKind::kDrop, .slave = 1, .count = 1});
  faults->plan(500us, {.kind = BusFaultKind::kDrop, .slave = 2, .count = 2});
  run(60ms);
  EXPECT_EQ(missing(1), 1U);
  EXPECT_EQ(missing(2), 2U);
}

TEST_F(BusFaultsTest, BitErrorsOfAnIdentifierByChance) {
  faults->plan(0ms, {.kind = BusFaultKind::kBitError, .identifier = 0x182, .mask = 0x7FF, .duration = 5ms});
  faults->plan(10ms, {.kind = BusFaultKind::kBitError, .identifier = 0x181, .mask = 0x7FF, .chance = 0.5, .seed = 7});
  run(9ms);
  EXPECT_EQ(bus.statistics().error_frames, 0U) << "another identifier";
  run(60ms);
  EXPECT_EQ(missing(1), 0U) << "they are repeated";
  EXPECT_GT(bus.statistics().error_frames, 10U);
  EXPECT_LT(bus.statistics().error_frames, 80U);
}

TEST_F(BusFaultsTest, ABrokenCableIsJoinedAgain) {
  faults->plan(9500us, {.kind = BusFaultKind::kCableBreak, .slave = 1, .duration = 10ms});
  run(60ms);
  EXPECT_GE(missing(2), 9U) << "nodes 1 and 2 go on without the third, at half of the terminators";
  EXPECT_GT(taken(2).size(), 15U);
  EXPECT_EQ(taken(2).back(), kFrames - 1);
}

TEST_F(BusFaultsTest, MissingTerminatorsMakeErrors) {
  faults->plan(10ms, {.kind = BusFaultKind::kNoTerminator, .end = BusEnd::kFirst, .duration = 20ms});
  faults->plan(15ms, {.kind = BusFaultKind::kNoTerminator, .end = BusEnd::kLast, .duration = 5ms});
  run(9ms);
  EXPECT_TRUE(bus.wiring().first_terminated && bus.wiring().last_terminated);
  run(16ms);
  EXPECT_FALSE(bus.wiring().first_terminated || bus.wiring().last_terminated);
  run(21ms);
  EXPECT_FALSE(bus.wiring().first_terminated) << "is still missing";
  EXPECT_TRUE(bus.wiring().last_terminated);
  run(60ms);
  EXPECT_TRUE(bus.wiring().first_terminated);
  EXPECT_GT(bus.statistics().error_frames, 0U);
  EXPECT_EQ(missing(1), 0U);
}

TEST_F(BusFaultsTest, ABabblingNode) {
  BusFault fault{.kind = BusFaultKind::kBabble, .slave = 2, .identifier = 0x10, .duration = 5ms};
  fault.frame.length = 2;
  fault.frame.data[0] = std::byte{0xAB};
  faults->plan(10ms, fault);
  run(60ms);
  const auto of_node = nodes[1].identifiers();
  EXPECT_GT(std::count(of_node.begin(), of_node.end(), 0x10U), 50);
  EXPECT_EQ(missing(1), 0U) << "frames of low priority wait for its end";
  const auto seen = std::find_if(nodes[1].received.begin(), nodes[1].received.end(),
                                 [](const auto& one) { return one.frame.identifier.value == 0x10; });
  EXPECT_EQ(seen->frame, Frame::of(0x10, hex("AB 00")));
}

TEST_F(BusFaultsTest, AWireHeldDominant) {
  faults->plan(10500us, {.kind = BusFaultKind::kDominant, .slave = 2, .duration = 1ms});
  run(60ms);
  EXPECT_THAT(nodes[1].states, ::testing::Contains(ErrorState::kPassive));
  EXPECT_EQ(taken(1).back(), kFrames - 1);
}

TEST_F(BusFaultsTest, ASlaveWithoutSupplyRestartsAtTheEnd) {
  faults->plan(10500us, {.kind = BusFaultKind::kPowerOff, .slave = 1, .duration = 5ms});
  run(12ms);
  EXPECT_FALSE(bus.controller(1).powered());
  bus.controller(1).set_power(true);
  EXPECT_FALSE(bus.controller(1).powered()) << "whatever its node says";
  run(60ms);
  EXPECT_TRUE(bus.controller(1).powered());
  EXPECT_EQ(missing(1), 5U);
  EXPECT_EQ(missing(2), 0U);
  EXPECT_THAT(restarted, ElementsAre(1, 1)) << "nothing goes on meanwhile";
}

TEST_F(BusFaultsTest, ASlaveWithAnotherBitRate) {
  faults->plan(10500us, {.kind = BusFaultKind::kBitRate, .slave = 1, .bit_rate = 500'000, .duration = 10ms});
  run(12ms);
  EXPECT_EQ(bus.controller(1).options().bit_rate, 500'000U);
  bus.controller(1).set_bit_rate(1'000'000);
  EXPECT_EQ(bus.controller(1).options().bit_rate, 500'000U) << "whatever its node says";
  run(60ms);
  EXPECT_EQ(bus.controller(1).options().bit_rate, 1'000'000U);
  EXPECT_GT(bus.statistics().error_frames, 0U);
  EXPECT_EQ(taken(1).back(), kFrames - 1);
}

TEST_F(BusFaultsTest, BusOffAndResetAreEvents) {
  faults->plan(9ms + 20us, {.kind = BusFaultKind::kBusOff, .slave = 0});
  faults->plan(12ms, {.kind = BusFaultKind::kReset, .slave = 2});
  run(9ms + 30us);
  EXPECT_THAT(nodes[0].states, ElementsAre(ErrorState::kBusOff)) << "in its own frame";
  run(60ms);
  EXPECT_THAT(nodes[0].states, ElementsAre(ErrorState::kBusOff, ErrorState::kActive));
  EXPECT_EQ(missing(1), 2U) << "the frame of 9 ms, and that of 10 ms, which it did not take during its recovery";
  EXPECT_THAT(restarted, ElementsAre(2));
  EXPECT_THAT(faults->active(), IsEmpty());
  EXPECT_TRUE(faults->take_event()->begins);
  EXPECT_EQ(faults->take_event()->fault.kind, BusFaultKind::kReset);
  EXPECT_FALSE(faults->take_event());
}

TEST_F(BusFaultsTest, OneOfAKindInAPlaceAndAtMostThirtyTwo) {
  EXPECT_TRUE(faults->begin({.kind = BusFaultKind::kDominant, .slave = 2}, bus.now()));
  EXPECT_TRUE(faults->begin({.kind = BusFaultKind::kDominant, .slave = 2, .duration = 1ms}, bus.now()));
  EXPECT_EQ(faults->active().size(), 1U);
  EXPECT_FALSE(faults->begin({.kind = BusFaultKind::kDominant, .slave = 3}, bus.now())) << "there is no such slave";
  EXPECT_FALSE(faults->begin({.kind = BusFaultKind::kDominant}, bus.now()));
  EXPECT_TRUE(faults->heal({.kind = BusFaultKind::kDominant, .slave = 2}, bus.now()));
  EXPECT_FALSE(faults->heal({.kind = BusFaultKind::kDominant, .slave = 2}, bus.now()));
  for (std::uint32_t i = 0; i < BusFaults::kMaxActive; ++i) {
    EXPECT_TRUE(faults->begin({.kind = BusFaultKind::kDrop, .identifier = i, .mask = 0x7FF}, bus.now()));
  }
  EXPECT_FALSE(faults->begin({.kind = BusFaultKind::kDrop, .identifier = 99, .mask = 0x7FF}, bus.now()));
  faults->plan(5ms, {.kind = BusFaultKind::kReset, .slave = 0});
  faults->heal_all(bus.now());
  EXPECT_THAT(faults->active(), IsEmpty());
  run(60ms);
  EXPECT_THAT(restarted, IsEmpty()) << "what was planned is forgotten";
  EXPECT_EQ(missing(1), 0U);
}

}  // namespace
}  // namespace driveline::slaves::can
