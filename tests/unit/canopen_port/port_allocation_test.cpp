// Ports allocate and lock only when they are opened. A separate program, because the guard replaces malloc.
#include <gtest/gtest.h>
#include <linux/can.h>

#include <cstring>

#include "driveline/canopen_port/can_capture.hpp"
#include "driveline/canopen_port/cannelloni_tcp_port.hpp"
#include "driveline/canopen_port/cannelloni_udp_port.hpp"
#include "driveline/canopen_port/slcan_port.hpp"
#include "driveline/canopen_port/socketcan_port.hpp"
#include "driveline/canopen_port/socketcand_port.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "peer.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::canopen {
namespace {

using port_test::Connection;
using port_test::kLong;
using port_test::Peer;
using port_test::write_all;

/// Heap and lock calls of a port that sends and receives; `arrival` is a frame, and garbage, as the other end sends it.
std::uint64_t calls_of(CanPort& port, rt::VirtualClock& clock, int far_end, std::string_view arrival) {
  std::array<char, 65'536> drain{};
  unsigned received = 0;
  rt::RtGuard::enter();
  for (int i = 0; i < 200; ++i) {
    static_cast<void>(port.send(Frame::remote({0x123, false}, 1)));
    static_cast<void>(::write(far_end, arrival.data(), arrival.size()));
    while (port.wait_readable(clock.now())) received += port.receive() ? 1U : 0U;
    static_cast<void>(port.statistics());
    static_cast<void>(::recv(far_end, drain.data(), drain.size(), MSG_DONTWAIT));
    clock.advance(std::chrono::milliseconds{50});
  }
  const auto calls = rt::RtGuard::leave().total();
  EXPECT_GE(received, 199U);
  return calls;
}

class CanPortAllocation : public testing::Test {
 protected:
  void SetUp() override {
    if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc; the guard counts nothing here";
  }
  rt::VirtualClock clock;
};

TEST_F(CanPortAllocation, NoneOfSlcan) {
  Connection line;
  std::unique_ptr<SlcanPort> port;
  {
    Peer adapter(line.far_end.get(), '\r', [](const std::string& text) { return text == "\r" ? "" : "\r"; });
    port = *must(SlcanPort::on(std::move(line.near_end), "test", {}, clock, kLong));
  }
  EXPECT_EQ(calls_of(*port, clock, line.far_end.get(), "hello\rF04\rz\rt12381122334455667788\r"), 0U);
}

TEST_F(CanPortAllocation, NoneOfSocketcand) {
  Connection line;
  write_all(line.far_end.get(), "< hi >");
  std::unique_ptr<SocketcandPort> port;
  {
    Peer server(line.far_end.get(), '>', [](const std::string&) { return "< ok >"; });
    port = *must(SocketcandPort::on(std::move(line.near_end), "test", "can0", {}, clock, kLong));
  }
  EXPECT_EQ(calls_of(*port, clock, line.far_end.get(), "< hello >< error 040 >< frame 123 1.0 1122 >"), 0U);
}

TEST_F(CanPortAllocation, NoneOfCannelloniOverTcp) {
  Connection line;
  write_all(line.far_end.get(), "CANNELLONIv1");
  const auto port = *must(CannelloniTcpPort::on(std::move(line.near_end), "test", {}, clock, kLong));
  EXPECT_EQ(calls_of(*port, clock, line.far_end.get(), std::string("\0\0\x01\x23\x01\xAA", 6)), 0U);
}

TEST_F(CanPortAllocation, NoneOfCannelloniOverUdp) {
  Connection line(SOCK_DGRAM);
  CannelloniUdpPort port(std::move(line.near_end), clock);
  EXPECT_EQ(calls_of(port, clock, line.far_end.get(), std::string("\x02\0\0\0\x01\0\0\x01\x23\x01\xAA", 11)), 0U);
}

TEST_F(CanPortAllocation, NoneOfSocketCanAndACapture) {
  const test::TemporaryFolder folder;
  Connection line(SOCK_SEQPACKET);
  SocketCanPort inner(std::move(line.near_end), {}, clock);
  const auto port = *must(CanCapture::open(inner, clock, {.file = folder.path / "can.pcapng"}));
  can_frame frame{};
  frame.can_id = 0x123;
  std::string message(sizeof frame, '\0');
  std::memcpy(message.data(), &frame, sizeof frame);
  EXPECT_EQ(calls_of(*port, clock, line.far_end.get(), message), 0U);
}

}  // namespace
}  // namespace driveline::canopen
