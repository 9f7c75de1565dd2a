// Tunnels of cannelloni over UDP and TCP. Bytes by the tables of its doc/udp_format.md and doc/tcp_protocol.md and the
// flags of linux/can.h.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>

#include "driveline/canopen_port/cannelloni_tcp_port.hpp"
#include "driveline/canopen_port/cannelloni_udp_port.hpp"
#include "peer.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using port_test::Connection;
using port_test::kLong;
using port_test::read_now;
using port_test::receive_one;
using port_test::write_all;
using testing::HasSubstr;
using namespace std::chrono_literals;

std::string text_of(std::string_view digits) {
  std::string text;
  for (const std::byte byte : hex(digits)) text += static_cast<char>(byte);
  return text;
}

class CannelloniUdpTest : public testing::Test {
 protected:
  /// Hands the port one packet.
  void peer_sends(std::string_view digits) { write_all(line.far_end.get(), text_of(digits)); }
  /// The next packet of the port.
  std::string peer_gets() {
    std::array<char, 2048> packet{};
    const ssize_t size = ::recv(line.far_end.get(), packet.data(), packet.size(), MSG_DONTWAIT);
    return size < 0 ? std::string("nothing") : std::string(packet.data(), static_cast<std::size_t>(size));
  }

  rt::VirtualClock clock;
  Connection line{SOCK_DGRAM};
  CannelloniUdpPort port{std::move(line.near_end), clock};
};

TEST_F(CannelloniUdpTest, EachFrameIsAPacketWithTheNextSequenceNumber) {
  EXPECT_EQ(port.send(Frame::of(0x100, hex("11 33"))), SendStatus::kSent);
  EXPECT_EQ(port.send(Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1"))), SendStatus::kSent);
  EXPECT_EQ(port.send(Frame::remote({0x70A, false}, 4)), SendStatus::kSent);
  EXPECT_EQ(peer_gets(), text_of("02 00 00 00 01  00 00 01 00 02 11 33"));
  EXPECT_EQ(peer_gets(), text_of("02 00 01 00 01  9A AA AA AA 02 01 F1"));
  EXPECT_EQ(peer_gets(), text_of("02 00 02 00 01  40 00 07 0A 04"));
  EXPECT_EQ(port.send(Frame::of(0x800, {})), SendStatus::kNotValid);
  EXPECT_EQ(peer_gets(), "nothing");
  EXPECT_EQ(port.statistics().sent, 3U);
}

TEST_F(CannelloniUdpTest, AllFramesOfAPacketArrive) {
  peer_sends("02 00 A7 00 03  00 00 01 00 02 11 33  9A AA AA AA 02 01 F1  40 00 07 0A 04");
  EXPECT_EQ(receive_one(port, clock), Frame::of(0x100, hex("11 33")));
  EXPECT_EQ(receive_one(port, clock), Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")));
  EXPECT_EQ(receive_one(port, clock), Frame::remote({0x70A, false}, 4));
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.statistics().lost, 0U);
}

TEST_F(CannelloniUdpTest, MissingSequenceNumbersAreLost) {
  for (const std::string_view sequence : {"FD", "FE", "01", "02", "00", "03"})  // FF is missing; 00 comes late
    peer_sends("02 00 " + std::string(sequence) + " 00 01  00 00 01 00 00");
  for (int i = 0; i < 6; ++i) EXPECT_EQ(receive_one(port, clock), Frame::of(0x100, {}));
  EXPECT_EQ(port.statistics().lost, 2U);  // FF and 00, of which one has come after all
  EXPECT_EQ(port.statistics().malformed, 0U);
}

TEST_F(CannelloniUdpTest, WhatIsNoPacketIsCounted) {
  peer_sends("FF");
  peer_sends("01 00 00 00 01  00 00 01 00 00");                             // version 1
  peer_sends("02 00 00 00 02  00 00 01 00 00");                             // announces two frames
  peer_sends("02 00 01 00 01  00 00 01 00 09 01 02 03 04 05 06 07 08 09");  // nine bytes
  peer_sends("02 00 02 00 01  20 00 00 80 08 00 00 00 00 00 00 00 00");     // an error frame: passed over
  peer_sends("02 00 03 00 01  00 00 01 23 00");
  EXPECT_EQ(receive_one(port, clock), Frame::of(0x100, {}));
  EXPECT_EQ(receive_one(port, clock), Frame::of(0x123, {}));
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.statistics().malformed, 4U);
}

TEST_F(CannelloniUdpTest, APeerThatDoesNotReadMakesThePortBusy) {
  auto status = SendStatus::kSent;
  for (int i = 0; i < 1'000'000 && status == SendStatus::kSent; ++i) status = port.send(Frame::of(0x100, {}));
  EXPECT_EQ(status, SendStatus::kBusy);
}

TEST_F(CannelloniUdpTest, ADeadlineWithoutAFrameGivesFalse) {
  EXPECT_FALSE(port.wait_readable(clock.now()));
  EXPECT_FALSE(port.wait_readable(clock.now() + 1ms));
  EXPECT_EQ(clock.now(), 1ms);
}

/// A UDP socket at a free port of this machine, and its address.
struct UdpPlace {
  UdpPlace() : socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof any;
    if (::bind(socket.get(), reinterpret_cast<sockaddr*>(&any), size) != 0 ||
        ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&any), &size) != 0) {
      throw std::runtime_error("no UDP port");
    }
    number = ntohs(any.sin_port);
  }
  rt::FileDescriptor socket;
  std::uint16_t number = 0;
};

TEST(CannelloniUdp, OpensALocalPortToWhichTheFarEndSends) {
  rt::MonotonicClock clock;
  const UdpPlace far;
  std::uint16_t local = 0;
  {
    const UdpPlace unused;
    local = unused.number;
  }
  const auto port = *must(CannelloniUdpPort::open("127.0.0.1:" + std::to_string(far.number), local, clock));
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);
  std::array<char, 64> packet{};
  sockaddr_in from{};
  socklen_t size = sizeof from;
  const auto bytes =
      ::recvfrom(far.socket.get(), packet.data(), packet.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
  EXPECT_EQ(bytes, 10);
  EXPECT_EQ(ntohs(from.sin_port), local);
  const std::string answer = text_of("02 00 00 00 01  00 00 03 21 00");
  ASSERT_EQ(::sendto(far.socket.get(), answer.data(), answer.size(), 0, reinterpret_cast<sockaddr*>(&from), size), 10);
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x321, {}));
  EXPECT_THAT(failure_text(CannelloniUdpPort::open("127.0.0.1:1", local, clock)),
              HasSubstr("cannot use the local UDP port " + std::to_string(local)));
}

TEST(CannelloniUdp, IsDownWhileNobodyListens) {
  rt::MonotonicClock clock;
  std::unique_ptr<CannelloniUdpPort> port;
  {
    const UdpPlace far;
    port = *must(CannelloniUdpPort::open("127.0.0.1:" + std::to_string(far.number), 0, clock));
  }
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);  // nothing is known yet
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kDown);
  EXPECT_FALSE(port->receive());
}

class CannelloniTcpTest : public testing::Test {
 protected:
  void open(const CanPortOptions& options = {}) {
    write_all(line.far_end.get(), "CANNELLONIv1");
    port = *must(CannelloniTcpPort::on(std::move(line.near_end), "test", options, clock, kLong));
    ASSERT_EQ(peer_gets(), "CANNELLONIv1");
  }
  void peer_sends(std::string_view digits) { write_all(line.far_end.get(), text_of(digits)); }
  std::string peer_gets() { return read_now(line.far_end.get()); }

  rt::VirtualClock clock;
  Connection line;
  std::unique_ptr<CannelloniTcpPort> port;
};

TEST_F(CannelloniTcpTest, FramesFollowOneAnother) {
  open();
  for (const auto& frame : {Frame::of(0x100, hex("11 33")), Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")),
                            Frame::remote({0x70A, false}, 4)})
    EXPECT_EQ(port->send(frame), SendStatus::kSent);
  EXPECT_EQ(peer_gets(), text_of("00 00 01 00 02 11 33  9A AA AA AA 02 01 F1  40 00 07 0A 04"));
  peer_sends("00 00 01 00 02 11");
  EXPECT_FALSE(port->receive());
  peer_sends("33  9A AA AA AA 02 01 F1  40 00 07 0A 04");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x100, hex("11 33")));
  EXPECT_EQ(receive_one(*port, clock), Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")));
  EXPECT_EQ(receive_one(*port, clock), Frame::remote({0x70A, false}, 4));
  EXPECT_EQ(port->statistics().malformed, 0U);
}

TEST_F(CannelloniTcpTest, FramesOfOtherKindsArePassedOver) {
  open();
  peer_sends("00 00 01 23 82 00 AA BB  00 00 08 00 00  20 00 00 40 08 00 00 00 00 00 00 00 00  00 00 02 34 01 55");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x234, hex("55")));
  EXPECT_EQ(port->statistics().malformed, 2U);  // CAN FD, and an identifier out of range
}

TEST_F(CannelloniTcpTest, ALengthThatNoFrameHasEndsTheConnection) {
  open();
  peer_sends("00 00 01 23 00  00 00 01 23 09 01 02 03 04 05 06 07 08 09");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  EXPECT_FALSE(port->wait_readable(clock.now() + kLong));  // at once
  EXPECT_TRUE(port->statistics().down);
  EXPECT_EQ(port->statistics().malformed, 1U);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kDown);
}

TEST_F(CannelloniTcpTest, APeerThatDoesNotReadMakesThePortBusy) {
  open();
  auto status = SendStatus::kSent;
  for (int i = 0; i < 10'000'000 && status == SendStatus::kSent; ++i) status = port->send(Frame::of(0x100, {}));
  EXPECT_EQ(status, SendStatus::kBusy);
}

TEST_F(CannelloniTcpTest, AnotherGreetingIsRefused) {
  write_all(line.far_end.get(), "CANNELLONIv2");
  EXPECT_EQ(failure_text(CannelloniTcpPort::on(std::move(line.near_end), "1.2.3.4:20000", {}, clock, kLong)),
            "the cannelloni peer at 1.2.3.4:20000 was expected to greet with CANNELLONIv1: it sends something else.");
}

TEST_F(CannelloniTcpTest, APeerThatSaysNothingIsRefused) {
  write_all(line.far_end.get(), "CANNELLONI");
  EXPECT_THAT(failure_text(CannelloniTcpPort::on(std::move(line.near_end), "here", {}, clock, 20ms)),
              HasSubstr("no answer."));
}

}  // namespace
}  // namespace driveline::canopen
