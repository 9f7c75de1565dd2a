// Frames that are submitted before the frames they depend on have returned.
#include <gmock/gmock.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "driveline/ecat_master/cyclic/acyclic_channel.hpp"
#include "driveline/ecat_master/cyclic/cyclic_exchange.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/wire/frame.hpp"
#include "support/fake_port.hpp"

namespace driveline::ecat_master {
namespace {

using ecat_master_test::FakePort;
using testing::ElementsAre;

/// A channel whose cycles the test runs; every frame returns in the cycle after its own.
struct Relays : testing::Test {
  /// Submits a frame with a write.
  bool submit(std::uint64_t id, std::uint64_t round, std::uint64_t behind) {
    AcyclicJob job;
    job.id = id;
    job.round = round;
    job.behind = behind;
    wire::FrameBuilder builder(job.bytes, FrameTag{}.to_mac());
    static_cast<void>(builder.add(wire::Command::kFpwr, 0, wire::DatagramAddress::physical(0x1001, 0x1800), 40));
    job.size = static_cast<std::uint16_t>(builder.finish().size());
    return channel.submit(job);
  }
  void send() { sequence = channel.send_due(port, {0, sequence}).sequence; }
  /// Returns a frame. `taken`: the working counter of its write is not zero.
  void bring_back(std::uint32_t number, bool taken = true) {
    auto answer = ecat_master_test::answered(port.sent[number - 1], std::byte{1});
    if (!taken) answer[answer.size() - 2] = std::byte{0};
    EXPECT_TRUE(channel.accept(answer, {0, number}));
  }
  /// Numbers of the returned jobs; unsent jobs are negative.
  std::vector<int> back() {
    std::vector<int> ids;
    AcyclicJob job;
    while (channel.take_answer(job)) ids.push_back(static_cast<int>(job.id) * (job.withheld ? -1 : 1));
    return ids;
  }

  rt::VirtualClock clock;
  FakePort port{clock};
  AcyclicChannel channel{3};
  std::uint32_t sequence = 0;
};

TEST_F(Relays, AFrameBehindARoundWaitsUntilAllOfThatRoundIsBack) {
  ASSERT_TRUE(submit(1, 1, 0) && submit(2, 1, 0) && submit(3, 2, 1));
  send();
  EXPECT_EQ(port.sent.size(), 2U);
  EXPECT_TRUE(channel.awaits_round());
  bring_back(1);
  send();
  EXPECT_EQ(port.sent.size(), 2U);
  bring_back(2);
  EXPECT_FALSE(channel.awaits_round());
  send();
  EXPECT_EQ(port.sent.size(), 3U);
  EXPECT_THAT(back(), ElementsAre(1, 2));
}

TEST_F(Relays, NothingIsSentBehindAWriteThatWasNotTaken) {
  ASSERT_TRUE(submit(1, 1, 0) && submit(2, 2, 1) && submit(3, 2, 1) && submit(4, 3, 2));
  send();
  bring_back(1, false);
  send();
  EXPECT_EQ(port.sent.size(), 1U);
  EXPECT_THAT(back(), ElementsAre(1, -2, -3, -4)) << "and nothing behind what was not sent";
  ASSERT_TRUE(submit(5, 4, 0));
  send();
  EXPECT_EQ(port.sent.size(), 2U) << "what waits for nothing goes";
}

TEST_F(Relays, NothingIsSentBehindALostFrame) {
  ASSERT_TRUE(submit(1, 1, 0) && submit(2, 2, 1));
  for (int cycle = 0; cycle < 3; ++cycle) {
    send();
    channel.end_cycle();
  }
  send();
  EXPECT_EQ(port.sent.size(), 1U);
  EXPECT_THAT(back(), ElementsAre(1, -2));
}

TEST_F(Relays, NothingIsSentBehindARoundThatNobodyKnows) {
  ASSERT_TRUE(submit(1, 2, 1));
  send();
  EXPECT_THAT(back(), ElementsAre(-1));
}

/// Requests of one byte; the test defines the slaves' answers per cycle.
struct RelayedRequests : Relays {
  std::vector<Request> requests(std::span<std::byte> data, wire::Command command = wire::Command::kFprd) {
    return {{command, wire::DatagramAddress::physical(0x1001, 0x1000), data}};
  }
  /// Runs a cycle: processes the returned frames, sends the next ones.
  void cycle() {
    while (returned < port.sent.size()) {
      const auto number = static_cast<std::uint32_t>(++returned);
      if (number == lost) continue;
      const auto fill = static_cast<std::byte>(number);
      static_cast<void>(channel.accept(ecat_master_test::answered(port.sent[number - 1], fill), {0, number}));
    }
    send();
    channel.end_cycle();
    ++cycles;
  }

  CyclicExchange exchange{channel, clock, [this](std::chrono::nanoseconds duration) {
                            clock.advance(duration);
                            cycle();
                          }};
  std::size_t returned = 0;
  std::uint32_t lost = 0;
  int cycles = 0;
};

TEST_F(RelayedRequests, UseEveryCycle) {
  std::array<std::array<std::byte, 1>, 10> data{};
  std::vector<std::vector<Request>> rounds;
  for (auto& bytes : data) rounds.push_back(requests(bytes));
  ASSERT_TRUE(exchange.relays());
  ASSERT_TRUE(exchange.relay({{}, rounds[0], rounds[1]}));
  for (std::size_t i = 1; i + 1 < rounds.size(); ++i) ASSERT_TRUE(exchange.relay({rounds[i], {}, rounds[i + 1]}));
  ASSERT_TRUE(exchange.relay({rounds.back(), {}, {}}));
  EXPECT_EQ(cycles, 11) << "ten frames, and one cycle for the last to come back";
  for (std::size_t i = 0; i < data.size(); ++i) {
    EXPECT_TRUE(rounds[i][0].answered);
    EXPECT_EQ(std::to_integer<std::size_t>(data[i][0]), i + 1);
  }
}

TEST_F(RelayedRequests, GoOnBesideTheRequestsOfOthers) {
  std::array<std::byte, 1> first{};
  std::array<std::byte, 1> second{};
  std::array<std::byte, 1> other{};
  auto one = requests(first);
  auto two = requests(second);
  auto three = requests(other);
  ASSERT_TRUE(exchange.relay({{}, one, two}));
  ASSERT_TRUE(exchange.exchange(three));
  EXPECT_TRUE(three[0].answered);
  ASSERT_TRUE(exchange.relay({two, {}, {}}));
  EXPECT_TRUE(two[0].answered);
  EXPECT_EQ(second[0], std::byte{2});
  EXPECT_EQ(other[0], std::byte{3});
}

TEST_F(RelayedRequests, AreWithheldWhenTheFrameInFrontOfThemIsRepeated) {
  std::array<std::byte, 1> first{};
  std::array<std::byte, 1> second{};
  auto one = requests(first);
  auto two = requests(second);
  lost = 1;
  ASSERT_TRUE(exchange.relay({{}, one, two}));
  EXPECT_TRUE(one[0].answered) << "at the second try";
  ASSERT_TRUE(exchange.relay({two, {}, {}}));
  EXPECT_TRUE(two[0].withheld);
  EXPECT_FALSE(two[0].answered);
  EXPECT_EQ(port.sent.size(), 2U);
}

TEST_F(RelayedRequests, AreSentOnce) {
  std::array<std::byte, 1> first{};
  std::array<std::byte, 1> second{};
  auto one = requests(first);
  auto two = requests(second);
  lost = 2;
  ASSERT_TRUE(exchange.relay({{}, one, two}));
  ASSERT_TRUE(exchange.relay({two, {}, {}}));
  EXPECT_FALSE(two[0].answered);
  EXPECT_FALSE(two[0].withheld);
  EXPECT_EQ(port.sent.size(), 2U);
}

TEST_F(RelayedRequests, OfAnotherExchangeStayUnanswered) {
  std::array<std::byte, 1> data{};
  auto one = requests(data);
  ASSERT_TRUE(exchange.relay({one, {}, {}}));
  EXPECT_FALSE(one[0].answered);
  EXPECT_TRUE(port.sent.empty());
}

}  // namespace
}  // namespace driveline::ecat_master
