// The client of socketcand against scripted servers. Elements are those of socketcand's doc/protocol.md.
#include "driveline/canopen_port/socketcand_port.hpp"

#include <gmock/gmock.h>

#include "peer.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using port_test::Connection;
using port_test::kLong;
using port_test::Peer;
using port_test::read_now;
using port_test::receive_one;
using port_test::write_all;
using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::chrono_literals;

class SocketcandPortTest : public testing::Test {
 protected:
  void open(const CanPortOptions& options = {}) {
    write_all(line.far_end.get(), "< hi >");
    Peer server(line.far_end.get(), '>', [](const std::string&) { return "< ok >"; });
    port = *must(SocketcandPort::on(std::move(line.near_end), "test", "can0", options, clock, kLong));
    commands = server.stop();
  }
  void server_sends(std::string_view text) { write_all(line.far_end.get(), text); }
  std::string server_gets() { return read_now(line.far_end.get()); }

  rt::VirtualClock clock;
  Connection line;
  std::unique_ptr<SocketcandPort> port;
  std::vector<std::string> commands;
};

TEST_F(SocketcandPortTest, OpensTheBusInRawMode) {
  open();
  EXPECT_THAT(commands, ElementsAre("< open can0 >", "< rawmode >"));
}

TEST_F(SocketcandPortTest, FramesAreElementsOfTheProtocol) {
  open();
  for (const auto& frame :
       {Frame::of(0x123, {}), Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")), Frame::remote({0x123, false}, 2)})
    EXPECT_EQ(port->send(frame), SendStatus::kSent);
  EXPECT_EQ(server_gets(), "< send 123 0 >< send 1AAAAAAA 2 01 F1 >< sendrtr 123 2 >");
  server_sends("< frame 123 23.424242 11 22 33 44 >< frame 1AAAAAAA 23.424242 01F1 >< rtr 123 23.424242 4 >");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, hex("11 22 33 44")));
  EXPECT_EQ(receive_one(*port, clock), Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")));
  EXPECT_EQ(receive_one(*port, clock), Frame::remote({0x123, false}, 4));
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().received, 3U);
  EXPECT_EQ(port->statistics().malformed, 0U);
}

// linux/can/error.h: 40h is bus off, 100h a restarted controller.
TEST_F(SocketcandPortTest, ErrorFramesTellTheStateAndAreReportedWhenAskedFor) {
  open({.error_frames = true});
  server_sends("< error 20000040 23.424242 >");
  EXPECT_EQ(receive_one(*port, clock).kind, FrameKind::kError);
  EXPECT_EQ(port->statistics().state, BusState::kBusOff);
  server_sends("< error 00000100 >");
  EXPECT_EQ(receive_one(*port, clock).kind, FrameKind::kError);
  EXPECT_EQ(port->statistics().state, BusState::kErrorActive);
  EXPECT_EQ(port->statistics().error_frames, 2U);
}

TEST_F(SocketcandPortTest, ErrorFramesAreNotReportedWhenNotAskedFor) {
  open();
  server_sends("< error 20000040 23.424242 >< frame 123 23.424242 >");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  EXPECT_EQ(port->statistics().state, BusState::kBusOff);
  EXPECT_EQ(port->statistics().error_frames, 0U);
}

TEST_F(SocketcandPortTest, ARefusedFrameIsLost) {
  open();
  EXPECT_EQ(port->send(Frame::remote({0x123, false}, 2)), SendStatus::kSent);
  server_sends("< error unknown command >");
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().lost, 1U);
}

TEST_F(SocketcandPortTest, GarbageIsCountedAndTheNextFrameIsGood) {
  open();
  server_sends("\xFF\x01 noise < frame 800 1.0 11 >< nonsense >< frame 123 1.0 AA >");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, hex("AA")));
  EXPECT_EQ(port->statistics().malformed, 3U);
}

TEST_F(SocketcandPortTest, AMebibyteWithoutAnElementIsSkipped) {
  open();
  std::thread writer([&] { server_sends("<" + std::string(1 << 20, 'x') + "< frame 123 1.0 >"); });
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  writer.join();
  EXPECT_EQ(port->statistics().malformed, 1U);
}

TEST_F(SocketcandPortTest, AServerThatDoesNotReadMakesThePortBusy) {
  open();
  const auto frame = Frame::of(0x100, hex("00 11 22 33 44 55 66 77"));
  auto status = SendStatus::kSent;
  for (int i = 0; i < 10'000'000 && status == SendStatus::kSent; ++i) status = port->send(frame);
  EXPECT_EQ(status, SendStatus::kBusy);
}

TEST_F(SocketcandPortTest, AServerThatEndsTheConnectionIsDown) {
  open();
  line.far_end = {};
  EXPECT_FALSE(port->wait_readable(clock.now() + kLong));  // at once
  EXPECT_TRUE(port->statistics().down);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kDown);
}

/// What opening says about a server that greets with `greeting`.
std::string open_failure(std::string_view greeting, const Peer::Answer& answer,
                         std::chrono::nanoseconds patience = kLong) {
  Connection line;
  rt::VirtualClock clock;
  write_all(line.far_end.get(), greeting);
  Peer server(line.far_end.get(), '>', answer);
  return failure_text(SocketcandPort::on(std::move(line.near_end), "1.2.3.4:29536", "can7", {}, clock, patience));
}

TEST(SocketcandOpen, TheReasonOfTheServerIsTheError) {
  EXPECT_EQ(open_failure("< hi >", [](const std::string&) { return "< error could not open bus >"; }),
            "the socketcand server at 1.2.3.4:29536 was expected to answer < open can7 > with < ok >: could not open "
            "bus.");
}

TEST(SocketcandOpen, AServerThatSaysNothing) {
  EXPECT_EQ(open_failure(
                "", [](const std::string&) { return ""; }, 20ms),
            "the socketcand server at 1.2.3.4:29536 was expected to greet with < hi >: no answer.");
}

TEST(SocketcandOpen, AnotherKindOfServer) {
  EXPECT_THAT(open_failure(
                  "SSH-2.0-OpenSSH_9.2\r\n", [](const std::string&) { return ""; }, 20ms),
              HasSubstr("to greet with < hi >: it sends something else."));
}

TEST(SocketcandOpen, AServerThatEndsTheConnection) {
  Connection line;
  rt::VirtualClock clock;
  line.far_end = {};
  EXPECT_THAT(failure_text(SocketcandPort::on(std::move(line.near_end), "here", "can0", {}, clock, kLong)),
              HasSubstr("it has closed the connection."));
}

}  // namespace
}  // namespace driveline::canopen
