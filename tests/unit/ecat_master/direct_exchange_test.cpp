#include "driveline/ecat_master/bus/direct_exchange.hpp"

#include <gmock/gmock.h>

#include <set>

#include "support/bytes.hpp"
#include "support/fake_port.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;
using ecat_master_test::answered;
using ecat_master_test::FakePort;
using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST(FrameTag, IsTheSourceAddress) {
  const auto mac = FrameTag{0x5A, 0x12345678}.to_mac();
  EXPECT_EQ(copy_of(mac), hex("00 5A 78 56 34 12"));
  EXPECT_EQ(FrameTag::from_mac(mac), (FrameTag{0x5A, 0x12345678}));
  EXPECT_FALSE(FrameTag::processed(mac));
}

TEST(FrameTag, SurvivesTheBitThatSlavesSet) {
  auto mac = FrameTag{0x1FFF, 0xFFFFFFFF}.to_mac();
  EXPECT_EQ(copy_of(mac), hex("F8 FF FF FF FF FF")) << "neither a multicast address nor a locally administered one";
  mac[0] |= std::byte{0x02};
  EXPECT_EQ(FrameTag::from_mac(mac), (FrameTag{0x1FFF, 0xFFFFFFFF}));
  std::vector<std::byte> frame(14);
  std::copy(mac.begin(), mac.end(), frame.begin() + 6);
  EXPECT_EQ(FrameTag::of(frame), (FrameTag{0x1FFF, 0xFFFFFFFF})) << "the same out of a whole frame";
  EXPECT_TRUE(FrameTag::processed(mac));
}

TEST(FrameTag, OfAGuestSaysSoAndCounts) {
  EXPECT_TRUE(FrameTag::of_guest(0x5A, 1).guest());
  EXPECT_EQ(copy_of(FrameTag::of_guest(0x5A, 0x12345).to_mac()), hex("00 5A 45 23 FF FF"));
  EXPECT_NE(FrameTag::of_guest(0x5A, 1), FrameTag::of_guest(0x5A, 2));
  EXPECT_FALSE((FrameTag{0x5A, 0x12345678}).guest());
}

TEST(FrameTag, EveryMasterOfAProcessGetsAnInstanceOfItsOwn) {
  std::set<std::uint16_t> given;
  for (int i = 0; i < 1000; ++i) given.insert(next_frame_instance());
  EXPECT_EQ(given.size(), 1000U);
  EXPECT_LT(*given.rbegin(), FrameTag::kInstances);
  rt::VirtualClock clock;
  FakePort port(clock);
  EXPECT_NE(DirectExchange(port, clock).instance(), DirectExchange(port, clock).instance());
}

/// Requests that own their data.
struct Requests {
  explicit Requests(std::size_t count, std::size_t bytes = 2) : data(count, std::vector<std::byte>(bytes)) {
    for (std::size_t i = 0; i < count; ++i) {
      list.push_back({wire::Command::kFprd,
                      wire::DatagramAddress::physical(static_cast<std::uint16_t>(0x1001 + i), 0x0130), data[i]});
    }
  }
  std::vector<std::vector<std::byte>> data;
  std::vector<Request> list;
};

class MatchAnswers : public testing::Test {
 protected:
  MatchAnswers() {
    wire::FrameBuilder builder(buffer, FrameTag{0, 1}.to_mac());
    for (std::size_t i = 0; i < 3; ++i) {
      static_cast<void>(
          builder.add(requests.list[i].command, static_cast<std::uint8_t>(i), requests.list[i].address, 2));
    }
    answer = answered(builder.finish(), std::byte{0xA5});
  }
  void expect_refused(std::span<const std::byte> frame, const char* why) {
    EXPECT_FALSE(match_answers(requests.list, frame)) << why;
    for (const auto& request : requests.list) {
      EXPECT_EQ(copy_of(request.data), hex("0000")) << why;
      EXPECT_EQ(request.working_counter, 0) << why;
      EXPECT_FALSE(request.answered) << why;
    }
  }

  static constexpr std::size_t kDatagram = 14;  // 10 + 2 + 2
  std::array<std::byte, 1514> buffer{};
  Requests requests{3};
  std::vector<std::byte> answer;
};

TEST_F(MatchAnswers, TakesTheRightFrame) {
  ASSERT_TRUE(match_answers(requests.list, answer));
  for (const auto& request : requests.list) {
    EXPECT_EQ(copy_of(request.data), hex("A5A5"));
    EXPECT_EQ(request.working_counter, 1);
    EXPECT_TRUE(request.answered);
  }
}

TEST_F(MatchAnswers, TakesNothingOutOfADamagedFrame) {
  for (std::size_t length = 0; length < 16 + 3 * kDatagram; ++length) {
    expect_refused(std::span(answer).first(length), "cut off");
  }
  auto changed = [&](std::size_t at, std::byte value) {
    auto frame = answer;
    frame[at] = value;
    return frame;
  };
  constexpr std::size_t kSecond = 16 + kDatagram;
  constexpr std::size_t kThird = kSecond + kDatagram;
  expect_refused(changed(12, std::byte{0x08}), "another EtherType");
  expect_refused(changed(15, std::byte{0x40}), "another type of EtherCAT frame");
  expect_refused(changed(kThird, std::byte{5}), "another command in the last datagram");
  expect_refused(changed(kThird + 1, std::byte{7}), "another index in the last datagram");
  expect_refused(changed(kThird + 4, std::byte{0x20}), "another register in the last datagram");
  expect_refused(changed(kThird + 6, std::byte{1}), "another length in the last datagram");
  expect_refused(changed(kSecond + 7, std::byte{0}), "the list ends early");
  expect_refused(changed(kThird + 7, std::byte{0x80}), "the list goes on");
}

TEST_F(MatchAnswers, TakesNothingOutOfADifferentOrder) {
  auto frame = answer;
  // Datagrams 0 and 1 swapped; both have a successor.
  std::swap_ranges(frame.begin() + 16, frame.begin() + 16 + kDatagram, frame.begin() + 16 + kDatagram);
  expect_refused(frame, "swapped");
}

TEST_F(MatchAnswers, ComparesWholeLogicalAddresses) {
  std::vector<std::byte> data(4);
  Request request{wire::Command::kLrw, wire::DatagramAddress::logical(0x00010000), data};
  wire::FrameBuilder builder(buffer, FrameTag{0, 1}.to_mac());
  static_cast<void>(builder.add(wire::Command::kLrw, 0, wire::DatagramAddress::logical(0x00010004), 4));
  EXPECT_FALSE(match_answers({&request, 1}, answered(builder.finish(), std::byte{1})));
}

class DirectExchangeTest : public testing::Test {
 protected:
  void answer_everything() {
    port.on_send = [this](auto frame) { port.arrive(answered(frame, std::byte{0x11})); };
  }

  rt::VirtualClock clock{milliseconds{1}};
  FakePort port{clock};
  DirectExchange exchange{port, clock, {milliseconds{2}, 4, 9}};
};

TEST_F(DirectExchangeTest, PacksAsManyDatagramsAsAFrameHolds) {
  answer_everything();
  // 1500 - 2 bytes hold 107 datagrams of 14 bytes.
  Requests requests(300);
  ASSERT_TRUE(exchange.exchange(requests.list));
  ASSERT_EQ(port.sent.size(), 3U);
  EXPECT_EQ(port.sent[0].size(), 16U + 107 * 14);
  EXPECT_EQ(port.sent[1].size(), 16U + 107 * 14);
  EXPECT_EQ(port.sent[2].size(), 16U + 86 * 14);
  for (const auto& request : requests.list) {
    EXPECT_TRUE(request.answered);
    EXPECT_EQ(request.working_counter, 1);
    EXPECT_EQ(copy_of(request.data), hex("1111"));
  }
  EXPECT_EQ(exchange.statistics().frames_sent, 3U);
  EXPECT_EQ(exchange.statistics().frames_received, 3U);
  EXPECT_EQ(exchange.statistics().frames_lost, 0U);
}

TEST_F(DirectExchangeTest, SendsWhatTheStandardSays) {
  answer_everything();
  std::vector<std::byte> data = hex("0200");
  Request request{wire::Command::kFpwr, wire::DatagramAddress::physical(0x1001, 0x0120), data};
  ASSERT_TRUE(exchange.exchange({&request, 1}));
  // Ethernet: broadcast, numbered source; EtherCAT: length 14, type 1; FPWR, index 0, 1001h, 0120h, 2 bytes, no
  // interrupt; data; working counter; padding to 60 bytes (ETG.1000.4 5.3, 5.4).
  auto expected = hex("FFFFFFFFFFFF 000901000000 88A4 0E10 05 00 0110 2001 0200 0000 0200 0000");
  expected.resize(60);
  EXPECT_EQ(port.sent.at(0), expected);
}

TEST_F(DirectExchangeTest, RepeatsTheLostFrameOnly) {
  Requests requests(300);
  int frames = 0;
  port.on_send = [&](auto frame) {
    if (++frames != 2) port.arrive(answered(frame, std::byte{0x11}));
  };
  ASSERT_TRUE(exchange.exchange(requests.list));
  ASSERT_EQ(port.sent.size(), 4U);
  // The same datagrams, another number.
  EXPECT_TRUE(std::equal(port.sent[1].begin() + 12, port.sent[1].end(), port.sent[3].begin() + 12, port.sent[3].end()));
  EXPECT_NE(port.sent[1], port.sent[3]);
  EXPECT_EQ(exchange.statistics().frames_lost, 1U);
}

TEST_F(DirectExchangeTest, LimitsTheFramesOnTheirWay) {
  Requests requests(100, 1400);
  std::size_t flying = 0;
  std::size_t most = 0;
  port.on_send = [&](auto frame) {
    most = std::max(most, ++flying);
    port.arrive(answered(frame, std::byte{0x11}), microseconds{500});
  };
  port.on_wait = [&] { flying = 0; };
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(most, DirectExchange::kMaxInFlight);
  EXPECT_EQ(port.sent.size(), 100U);
  for (const auto& request : requests.list) EXPECT_TRUE(request.answered);
}

TEST_F(DirectExchangeTest, GivesUpAfterTheRetries) {
  Requests requests(1);
  const auto begin = clock.now();
  const auto done = exchange.exchange(requests.list);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::NoAnswer>());
  EXPECT_EQ(std::get<facts::NoAnswer>(done.error().facts).tries, 5U);
  EXPECT_EQ(port.sent.size(), 5U);
  EXPECT_EQ(clock.now() - begin, milliseconds{2 + 8 + 32 + 128 + 512});
  EXPECT_FALSE(requests.list[0].answered);
  EXPECT_EQ(exchange.statistics().frames_lost, 5U);
}

TEST_F(DirectExchangeTest, WaitsForSlavesThatAMachineHasSuspended) {
  // When it returns, everything received meanwhile is processed in order.
  const auto back = clock.now() + milliseconds{150};
  port.on_send = [&](auto frame) {
    const auto number = static_cast<std::byte>(port.sent.size());
    port.arrive(answered(frame, number), std::max<std::chrono::nanoseconds>(back - clock.now(), microseconds{500}));
  };
  Requests requests(1);
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(copy_of(requests.list[0].data), hex("0404"));
  EXPECT_EQ(clock.now(), back);
  EXPECT_EQ(exchange.statistics().frames_stale, 3U);
}

TEST_F(DirectExchangeTest, WaitsNoLongerForALostFrameThanFor2Ms) {
  for (int i = 0; i < 3; ++i) {
    Requests requests(1);
    bool lost = false;
    port.on_send = [&](auto frame) {
      if (std::exchange(lost, true)) port.arrive(answered(frame, std::byte{0x11}));
    };
    const auto begin = clock.now();
    ASSERT_TRUE(exchange.exchange(requests.list));
    // Independent of the time-out of the previous exchange.
    EXPECT_LT(clock.now() - begin, milliseconds{3});
  }
}

TEST_F(DirectExchangeTest, WaitsHalfASecondForATryAtMost) {
  DirectExchange patient(port, clock, {.retries = 9});
  Requests requests(1);
  const auto begin = clock.now();
  ASSERT_FALSE(patient.exchange(requests.list));
  EXPECT_EQ(clock.now() - begin, milliseconds{2 + 8 + 32 + 128 + 6 * 512});
}

TEST_F(DirectExchangeTest, DoesNotTakeTheLateAnswerOfAnEarlierTry) {
  Requests requests(1);
  port.on_send = [&](auto frame) {
    // The first attempt is answered while the second is awaited, with an older content.
    const bool first = port.sent.size() == 1;
    port.arrive(answered(frame, first ? std::byte{0x01} : std::byte{0x02}),
                first ? microseconds{2100} : microseconds{500});
  };
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(copy_of(requests.list[0].data), hex("0202"));
  EXPECT_EQ(exchange.statistics().frames_stale, 1U);
  EXPECT_EQ(exchange.statistics().frames_received, 1U);
}

TEST_F(DirectExchangeTest, DoesNotTakeTheAnswerOfAnEarlierExchange) {
  Requests first(1);
  port.on_send = [&](auto frame) {
    port.arrive(answered(frame, std::byte{0x01}));
    port.arrive(answered(frame, std::byte{0x01}), microseconds{50});  // twice
  };
  ASSERT_TRUE(exchange.exchange(first.list));
  clock.advance(microseconds{100});
  port.on_send = [&](auto frame) { port.arrive(answered(frame, std::byte{0x02})); };
  Requests second(1);
  ASSERT_TRUE(exchange.exchange(second.list));
  EXPECT_EQ(copy_of(second.list[0].data), hex("0202"));
  EXPECT_EQ(exchange.statistics().frames_stale, 1U);
}

TEST_F(DirectExchangeTest, CountsAndIgnoresWhatIsNotItsOwn) {
  Requests requests(1);
  port.on_send = [&](auto frame) {
    auto other_master = answered(frame, std::byte{0x66});
    other_master[7] = std::byte{8};
    port.arrive(other_master);
    port.arrive(hex("FFFFFFFFFFFF 000901000000 0800 4500"));  // no EtherCAT
    port.arrive(hex("FFFF"));
    auto damaged = answered(frame, std::byte{0x66});
    damaged[16] = std::byte{1};
    port.arrive(damaged);
    port.arrive(answered(frame, std::byte{0x22}), microseconds{100});
  };
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(copy_of(requests.list[0].data), hex("2222"));
  EXPECT_EQ(exchange.statistics().frames_foreign, 4U);
  EXPECT_EQ(exchange.statistics().frames_of_masters, 1U);
  EXPECT_EQ(describe_traffic(exchange.statistics()),
            "another EtherCAT master is on the wire: 1 of its frames were received, the last one from "
            "02:08:01:00:00:00; two masters disturb each other");
}

TEST_F(DirectExchangeTest, OfAGuestIsNobodyToSpeakOfForOthers) {
  std::vector<std::byte> heard;
  port.on_send = [&](auto frame) {
    heard = answered(frame, std::byte{0x11});
    port.arrive(heard);
  };
  DirectExchange guest(port, clock, {.guest = true});
  for (int i = 0; i < 3; ++i) {
    Requests requests(1);
    ASSERT_TRUE(guest.exchange(requests.list)) << "it knows its own frames";
  }
  port.on_send = [&](auto frame) {
    port.arrive(heard);
    port.arrive(answered(frame, std::byte{0x22}));
  };
  Requests requests(1);
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(exchange.statistics().frames_foreign, 0U);
  EXPECT_EQ(describe_traffic(exchange.statistics()), "");
}

TEST_F(DirectExchangeTest, TreatsAFullQueueAsALostFrame) {
  answer_everything();
  port.refusals = {port::SendStatus::kBusy, port::SendStatus::kBusy};
  Requests requests(1);
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_EQ(port.sent.size(), 1U);
}

TEST_F(DirectExchangeTest, SaysAtOnceThatTheLinkIsDown) {
  port.refusals = {port::SendStatus::kLinkDown};
  Requests requests(1);
  const auto begin = clock.now();
  const auto done = exchange.exchange(requests.list);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::LinkDown>());
  EXPECT_EQ(clock.now(), begin);
}

TEST_F(DirectExchangeTest, RefusesARequestThatFitsNoFrame) {
  answer_everything();
  Requests longest(1, 1486);
  EXPECT_TRUE(exchange.exchange(longest.list));
  Requests longer(1, 1487);
  const auto done = exchange.exchange(longer.list);
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::ProcessDataSize>());
  EXPECT_EQ(std::get<facts::ProcessDataSize>(done.error().facts).limit, 1486U);
  EXPECT_EQ(std::get<facts::ProcessDataSize>(done.error().facts).bytes, 1487U);
}

TEST_F(DirectExchangeTest, AWorkingCounterOfZeroIsAnAnswer) {
  port.on_send = [&](auto frame) { port.arrive(copy_of(frame)); };
  Requests requests(2);
  ASSERT_TRUE(exchange.exchange(requests.list));
  EXPECT_TRUE(requests.list[1].answered);
  EXPECT_EQ(requests.list[1].working_counter, 0);
}

}  // namespace
}  // namespace driveline::ecat_master
