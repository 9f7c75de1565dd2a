// Frames through a line of slaves: order, times, lengths of replies, kinds of frames.
#include "support/must.hpp"
#include "test_line.hpp"

namespace driveline::slaves::test {
namespace {

using wire::DatagramAddress;

TEST_F(LineTest, EverySlaveIsCountedAndAddressedByPosition) {
  build(5);
  const auto all = must(exchange(Command::kBrd, DatagramAddress::physical(0, 0x0000), bytes({0})));
  EXPECT_EQ(all->working_counter, 5);
  EXPECT_EQ(all->adp, 5);
  EXPECT_EQ(all->data, bytes({0x11}));
  for (std::uint16_t i = 0; i < 5; ++i) {
    const auto address = bytes::to_le_bytes(static_cast<std::uint16_t>(0x1001 + i));
    const auto reply =
        must(exchange(Command::kApwr, DatagramAddress::position(i, 0x0010), {address.begin(), address.end()}));
    EXPECT_EQ(reply->working_counter, 1);
    EXPECT_EQ(peek(i, reg::kStationAddress), 0x1001 + i);
  }
  const auto nobody = exchange(Command::kAprd, DatagramAddress::position(5, 0x0010), bytes({0}));
  EXPECT_EQ(nobody->working_counter, 0);
  EXPECT_EQ(exchange(Command::kFprd, DatagramAddress::physical(0x1003, 0x0010), bytes({0, 0}))->data, bytes({3, 0x10}));
}

TEST_F(LineTest, MultipleWriteTakesFromTheAddressedSlaveAndGivesToThoseBehind) {
  build(4);
  for (std::uint16_t i = 0; i < 4; ++i) {
    exchange(Command::kApwr, DatagramAddress::position(i, 0x1F00), bytes({0x10U + i}));
  }
  const auto reply = exchange(Command::kArmw, DatagramAddress::position(1, 0x1F00), bytes({0xAA}));
  EXPECT_EQ(reply->working_counter, 4);
  EXPECT_EQ(reply->data, bytes({0x11}));
  const auto ram = [this](std::uint16_t i) {
    return exchange(Command::kAprd, DatagramAddress::position(i, 0x1F00), bytes({0}))->data;
  };
  EXPECT_EQ(ram(0), bytes({0xAA})) << "in front of it: what the master sent";
  EXPECT_EQ(ram(1), bytes({0x11}));
  EXPECT_EQ(ram(2), bytes({0x11}));
  EXPECT_EQ(ram(3), bytes({0x11}));
}

TEST_F(LineTest, ReplyDiffersFromTheRequestOnlyWhereItMay) {
  build(2);
  for (const std::size_t length : {1U, 32U, 33U, 500U, 1486U}) {
    const auto frame = make_frame(Command::kFprd, DatagramAddress::physical(0x0BAD, 0x1000),
                                  std::vector<std::byte>(length, std::byte{0xC3}));
    const auto reply = must(exchange(frame, line(), line()));
    ASSERT_EQ(reply->frame.size(), frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      if (i == 6) continue;
      EXPECT_EQ(reply->frame[i], frame[i]) << "byte " << i;
    }
    EXPECT_EQ(reply->frame[6], frame[6] | std::byte{0x02}) << "source address locally administered";
  }
}

TEST_F(LineTest, BytesBehindTheLastDatagramComeBackUnchanged) {
  build(1);
  auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  for (std::size_t i = 29; i < frame.size(); ++i) frame[i] = static_cast<std::byte>(i);
  EXPECT_TRUE(std::equal(frame.begin() + 29, frame.end(), must(exchange(frame, line(), line()))->frame.begin() + 29));
}

TEST_F(LineTest, SeveralDatagramsTakeEffectInOrder) {
  build(2);
  std::vector<std::byte> buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, kMac);
  const auto address = builder.add(Command::kApwr, 1, DatagramAddress::position(1, 0x0010), 2);
  builder.data(*address)[0] = std::byte{0x77};
  builder.add(Command::kFprd, 2, DatagramAddress::physical(0x0077, 0x0010), 2);
  builder.add(Command::kBrd, 3, DatagramAddress::physical(0, 0x0130), 2);
  EXPECT_EQ(line().send(builder.finish()), port::SendStatus::kSent);
  ASSERT_TRUE(line().wait_readable(clock().now() + 1ms));
  auto cursor = wire::DatagramCursor::open(line().receive()->bytes);
  EXPECT_EQ(cursor->next()->working_counter(), 1);
  const auto second = cursor->next();
  EXPECT_EQ(second->working_counter(), 1) << "the address written by the datagram before counts already";
  EXPECT_EQ(second->data[0], std::byte{0x77});
  const auto third = cursor->next();
  EXPECT_EQ(third->working_counter(), 2);
  EXPECT_TRUE(cursor->done());
}

TEST_F(LineTest, FramesWaitForThoseBeforeThem) {
  LineOptions options;
  options.delays = {500ns, 300ns};
  options.byte_time = 80ns;
  build(1, options);
  const auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  for (int i = 0; i < 3; ++i) ASSERT_EQ(line().send(frame), port::SendStatus::kSent);
  ASSERT_TRUE(line().wait_readable(clock().now() + 1ms));
  auto before = line().receive()->time;
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(line().wait_readable(clock().now() + 1ms));
    const auto time = line().receive()->time;
    EXPECT_EQ(time - before, (60 + 24) * 80ns) << "frame, preamble, FCS and gap (IEEE 802.3)";
    before = time;
  }
  const auto later = clock().now() + 1ms;
  clock().sleep_until(later);
  ASSERT_EQ(line().send(frame), port::SendStatus::kSent);
  ASSERT_TRUE(line().wait_readable(clock().now() + 1ms));
  EXPECT_LT(line().receive()->time, later + 60 * 80ns + 2us) << "the wire is free again";
}

TEST_F(LineTest, TheFrameIsOnTheWireForItsTime) {
  LineOptions options;
  options.delays = {500ns, 300ns};
  options.cable_delay = 10ns;
  options.byte_time = 80ns;
  build(2, options);
  const auto start = clock().now();
  const auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  ASSERT_EQ(line().send(frame), port::SendStatus::kSent);
  EXPECT_EQ(line().last_send_time(), start);
  EXPECT_FALSE(line().receive());
  const auto arrival = start + 10ns + 510ns + 500ns + 10ns + 300ns + 10ns + 60 * 80ns;
  EXPECT_FALSE(line().wait_readable(arrival - 1ns));
  EXPECT_FALSE(line().receive());
  EXPECT_TRUE(line().wait_readable(arrival + 1s));
  EXPECT_EQ(clock().now(), arrival);
  const auto received = must(line().receive());
  EXPECT_EQ(received->time, arrival);
  EXPECT_FALSE(line().receive());
  EXPECT_FALSE(line().wait_readable(clock().now() + 5us));
  EXPECT_EQ(clock().now(), arrival + 5us);
}

TEST_F(LineTest, ASpinningMasterGetsItsReply) {
  build(8);
  ASSERT_EQ(line().send(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kSent);
  int turns = 0;
  auto reply = line().receive();
  for (; !reply && turns < 1000; ++turns) {
    clock().spin();
    reply = line().receive();
  }
  ASSERT_TRUE(reply);
  EXPECT_GT(turns, 0);
}

TEST_F(LineTest, SeveralFramesInFlightComeBackInOrder) {
  build(3);
  for (unsigned i = 0; i < LineEnd::kMaxInFlight; ++i) {
    ASSERT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({i}))),
              port::SendStatus::kSent);
  }
  EXPECT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kBusy);
  clock().advance(1ms);
  for (unsigned i = 0; i < LineEnd::kMaxInFlight; ++i) {
    const auto received = must(line().receive());
    EXPECT_EQ(parse(received->bytes).data, bytes({i}));
  }
  EXPECT_FALSE(line().receive());
  EXPECT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kSent);
}

TEST_F(LineTest, AReceivedFrameStaysValidUntilTheNextReceive) {
  build(1);
  ASSERT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({1}))),
            port::SendStatus::kSent);
  clock().advance(1ms);
  const auto first = must(line().receive());
  unsigned sent = 0;
  while (line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({2}))) ==
         port::SendStatus::kSent) {
    ++sent;
  }
  EXPECT_EQ(sent, LineEnd::kMaxInFlight - 1) << "one slot is still in the receiver's hands";
  EXPECT_EQ(parse(first->bytes).data, bytes({1}));
}

TEST_F(LineTest, AShortFrameDoesNotOvertakeALongOne) {
  LineOptions options;
  options.byte_time = 80ns;
  build(1, options);
  const auto start = clock().now();
  for (const std::size_t length : {1000U, 1U}) {
    ASSERT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), std::vector<std::byte>(length))),
              port::SendStatus::kSent);
  }
  clock().advance(1ms);
  const auto first = must(line().receive());
  EXPECT_EQ(first->bytes.size(), 1028U);
  const auto first_time = first->time;
  EXPECT_GT(first_time, start + 1028 * 80ns);
  const auto second = must(line().receive());
  EXPECT_EQ(second->time, first_time + (24 + 60) * 80ns) << "behind the FCS and the gap of the first";
}

TEST_F(LineTest, AFrameThatWasReceivedIsNotWaitedForAgain) {
  build(1);
  ASSERT_EQ(line().send(make_frame(Command::kNop, DatagramAddress::physical(0, 0), bytes({1}))),
            port::SendStatus::kSent);
  ASSERT_TRUE(line().wait_readable(clock().now() + 1ms));
  ASSERT_TRUE(line().receive());
  EXPECT_FALSE(line().wait_readable(clock().now() + 1ms));
}

TEST_F(LineTest, TooLongFramesAreRefused) {
  build(1);
  EXPECT_EQ(line().send(std::vector<std::byte>(port::kMaxFrameBytes + 1)), port::SendStatus::kTooLong);
}

TEST_F(LineTest, SlavesLiveBetweenFrames) {
  build(2);
  clock().advance(50ms);
  line().advance(clock().now());
  EXPECT_EQ(device(0).local_time, clock().now());
  EXPECT_EQ(device(1).local_time, clock().now());
}

TEST_F(LineTest, VlanTaggedFrames) {
  build(2);
  auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  const auto tag = bytes({0x81, 0x00, 0xE0, 0x05});
  frame.insert(frame.begin() + 12, tag.begin(), tag.end());
  const auto reply = must(exchange(frame, line(), line()));
  EXPECT_EQ(reply->working_counter, 2);
  EXPECT_TRUE(std::equal(tag.begin(), tag.end(), reply->frame.begin() + 12));
  EXPECT_EQ(reply->frame.size(), frame.size());
}

/// EtherCAT in UDP: IPv4 header with `options` 32-bit words of options, UDP to port 0x88A4 with a checksum.
std::vector<std::byte> in_udp(const std::vector<std::byte>& frame, unsigned options = 0) {
  std::vector<std::byte> result(frame.begin(), frame.begin() + 12);
  auto append = [&result](std::initializer_list<unsigned> values) {
    for (const auto value : values) result.push_back(static_cast<std::byte>(value));
  };
  append({0x08, 0x00, 0x45 + options, 0, 0, 0x60, 0x12, 0x34, 0x40, 0, 64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2});
  for (unsigned i = 0; i < options; ++i) append({1, 1, 1, 1});
  append({0xC0, 0x00, 0x88, 0xA4, 0, 0x40, 0xBE, 0xEF});
  result.insert(result.end(), frame.begin() + 14, frame.end());
  return result;
}

TEST_F(LineTest, EtherCatInUdp) {
  build(3);
  for (const unsigned options : {0U, 2U}) {
    auto frame = in_udp(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0})), options);
    ASSERT_TRUE(line().process(frame, clock().now()));
    const std::size_t datagram = 14 + 20 + 4 * options + 8 + 2;
    EXPECT_EQ(frame[datagram + 10], std::byte{0x11});
    EXPECT_EQ(frame[datagram + 11], std::byte{3}) << "working counter";
    EXPECT_EQ(frame[datagram - 4], std::byte{0}) << "UDP checksum cleared";
    EXPECT_EQ(frame[datagram - 3], std::byte{0});
  }
}

TEST_F(LineTest, OtherUdpFragmentsAndProtocolsAreForeign) {
  build(1);
  const auto good = in_udp(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0})));
  struct Change {
    std::size_t at;
    unsigned value;
  };
  for (const auto& change : {Change{23, 6}, Change{36, 0x12}, Change{20, 0x20}, Change{21, 0x01}, Change{14, 0x65},
                             Change{14, 0x44}, Change{12, 0x86}}) {
    auto frame = good;
    frame[change.at] = static_cast<std::byte>(change.value);
    const auto before = frame;
    EXPECT_FALSE(line().process(frame, clock().now())) << "destroyed, byte " << change.at;
    EXPECT_EQ(frame, before);
  }
  EXPECT_EQ(line().counters().foreign, 7U);
}

TEST_F(LineTest, ForeignFramesAreForwardedWhenDlControlSaysSo) {
  build(2);
  std::vector<std::byte> arp(60);
  arp[12] = std::byte{0x08};
  arp[13] = std::byte{0x06};
  auto frame = arp;
  EXPECT_FALSE(line().process(frame, clock().now()));
  exchange(Command::kBwr, DatagramAddress::physical(0, 0x0100), bytes({0}));
  EXPECT_TRUE(line().process(frame, clock().now()));
  EXPECT_EQ(frame, arp);
  EXPECT_EQ(line().counters().foreign, 2U);
  EXPECT_EQ(line().counters().lost, 1U);
}

TEST_F(LineTest, OtherEtherCatTypesPassUnchanged) {
  build(2);
  auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  frame[15] = std::byte{0x50};  // type 5
  const auto before = frame;
  EXPECT_TRUE(line().process(frame, clock().now()));
  EXPECT_EQ(frame, before);
}

TEST_F(LineTest, DatagramsInFrontOfABrokenOneStillCount) {
  build(2);
  std::vector<std::byte> buffer(port::kMaxFrameBytes);
  wire::FrameBuilder builder(buffer, kMac);
  builder.add(Command::kBrd, 1, DatagramAddress::physical(0, 0), 1);
  const auto second = builder.add(Command::kBrd, 2, DatagramAddress::physical(0, 0), 8);
  const auto finished = builder.finish();
  std::vector<std::byte> frame(finished.begin(), finished.end());
  frame[second->header + 6] = std::byte{0xFF};  // a length beyond the frame
  EXPECT_TRUE(line().process(frame, clock().now()));
  EXPECT_EQ(frame[16 + 11], std::byte{2});
  EXPECT_EQ(frame[second->working_counter()], std::byte{0});
  EXPECT_EQ(line().counters().malformed, 1U);
  EXPECT_EQ(peek(0, reg::kProcessingUnitErrorCounter), 1);
  EXPECT_EQ(peek(1, reg::kProcessingUnitErrorCounter), 1);
}

TEST_F(LineTest, AFrameLengthBeyondTheFrameIsMalformedButProcessed) {
  build(1);
  auto frame = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}));
  frame[14] = std::byte{0xFF};
  frame[15] = std::byte{0x17};
  EXPECT_TRUE(line().process(frame, clock().now()));
  EXPECT_EQ(frame[16 + 11], std::byte{1});
  EXPECT_EQ(line().counters().malformed, 1U);
}

TEST_F(LineTest, TruncatedFramesProcessWhatIsThere) {
  build(1);
  const auto whole = make_frame(Command::kBrd, DatagramAddress::physical(0, 0), std::vector<std::byte>(100));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::vector<std::byte> frame(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    line().process(frame, clock().now());
    EXPECT_EQ(frame.size(), length);
  }
  EXPECT_EQ(line().counters().malformed, 114U) << "all that have an EtherCAT type but not all of their datagram";
}

TEST_F(LineTest, EmptyLineHasNoLink) {
  build(0);
  EXPECT_EQ(line().send(make_frame(Command::kBrd, DatagramAddress::physical(0, 0), bytes({0}))),
            port::SendStatus::kLinkDown);
}

TEST_F(LineTest, WiringMustFit) {
  std::vector<std::unique_ptr<Slave>> slaves;
  EXPECT_THROW(SimulatedLine(clock(), std::move(slaves), {}, Wiring::line(3)), std::invalid_argument);
}

TEST_F(LineTest, ReceiveTimesTellTheOrderOfSlaves) {
  LineOptions options;
  options.delays = {500ns, 300ns};
  options.cable_delay = 10ns;
  build(3, options);
  exchange(Command::kBwr, DatagramAddress::physical(0, 0x0900), bytes({0, 0, 0, 0}));
  const auto port0 = [this](std::size_t i) { return peek(i, reg::kReceiveTimePort, 0); };
  const auto port1 = [this](std::size_t i) { return peek(i, reg::kReceiveTimePort, 1); };
  EXPECT_EQ(port0(1) - port0(0), 510U);
  EXPECT_EQ(port0(2) - port0(1), 510U);
  EXPECT_EQ(port1(0) - port0(0), 510U + 510U + 510U + 310U);
  EXPECT_EQ(port1(1) - port0(1), 510U + 510U);
  EXPECT_EQ(port1(2), 0U);
}

}  // namespace
}  // namespace driveline::slaves::test
