// Texts that name ports.
#include "driveline/canopen_port/open_can_port.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>

#include <string>

#include "peer.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using port_test::Peer;
using port_test::read_now;
using port_test::receive_one;
using port_test::write_all;
using testing::HasSubstr;

/// A TCP server with one client in this process.
class Server {
 public:
  Server() : listener_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof any;
    if (::bind(listener_.get(), reinterpret_cast<sockaddr*>(&any), size) != 0 || ::listen(listener_.get(), 1) != 0 ||
        ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&any), &size) != 0) {
      throw std::runtime_error("no TCP port");
    }
    address = "127.0.0.1:" + std::to_string(ntohs(any.sin_port));
  }
  rt::FileDescriptor accept() const { return rt::FileDescriptor{::accept(listener_.get(), nullptr, nullptr)}; }

  std::string address;

 private:
  rt::FileDescriptor listener_;
};

TEST(OpenCanPort, OpensServersOverTcp) {
  struct Row {
    std::string prefix, suffix, greeting;
    char end;
    std::string answer, sent, frame;
  };
  const std::vector<Row> rows{
      {"slcan:tcp:", "", "", '\r', "\r", "t1230\r", "t3210\r"},
      {"socketcand:", "/can0", "< hi >", '>', "< ok >", "< send 123 0 >", "< frame 321 1.0 >"},
      {"cannelloni:tcp:", "", "CANNELLONIv1", '\0', "", std::string("\0\0\x01\x23\0", 5),
       std::string("\0\0\x03\x21\0", 5)},
  };
  for (const Row& row : rows) {
    rt::MonotonicClock clock;
    const Server server;
    std::unique_ptr<CanPort> port;
    std::thread client([&] {
      auto opened = open_can_port(row.prefix + server.address + row.suffix, {}, clock);
      EXPECT_EQ(failure_text(opened), "") << row.prefix;
      if (opened) port = std::move(*opened);
    });
    const auto connection = server.accept();
    write_all(connection.get(), row.greeting);
    Peer peer(connection.get(), row.end,
              [&](const std::string& text) { return text == "\r" ? std::string() : row.answer; });
    client.join();
    peer.stop();
    static_cast<void>(read_now(connection.get()));
    ASSERT_NE(port, nullptr);
    EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);
    EXPECT_THAT(port_test::read_until(connection.get(), row.sent), HasSubstr(row.sent));
    write_all(connection.get(), row.frame);
    EXPECT_EQ(receive_one(*port, clock), Frame::of(0x321, {}));
  }
}

TEST(OpenCanPort, OpensATunnelOverUdp) {
  rt::MonotonicClock clock;
  const auto port = must(open_can_port("cannelloni:udp:localhost:20000", {}, clock));
  EXPECT_FALSE((*port)->receive());
}

TEST(OpenCanPort, TextsThatNameNoPort) {
  struct Row {
    std::string text, part;
  };
  rt::MonotonicClock clock;
  for (const Row& row : std::vector<Row>{
           {"", "names no port to a CAN bus; an interface (can0), slcan:, socketcand: or cannelloni: was expected"},
           {"usb:can0", "names no port to a CAN bus"},
           {"/dev/ttyACM0", "names no port to a CAN bus"},
           {"socketcan:", "names no port to a CAN bus"},
           {"slcan:", "slcan:/dev/ttyACM0 or slcan:tcp:HOST:PORT was expected"},
           {"slcan:tcp:", "is no HOST:PORT"},
           {"slcan:tcp:localhost", "'localhost' is no HOST:PORT"},
           {"slcan:tcp:localhost:0", "PORT is 1 to 65535"},
           {"slcan:tcp:localhost:65536", "PORT is 1 to 65535"},
           {"slcan:tcp:example.org:1", "HOST is an IPv4 address or localhost"},
           {"slcan:tcp:127.0.0.1:1:2", "is no HOST:PORT"},
           {"socketcand:127.0.0.1:29536", "socketcand:HOST:PORT/BUS was expected"},
           {"socketcand:127.0.0.1:29536/", "socketcand:HOST:PORT/BUS was expected"},
           {"socketcand:127.0.0.1:29536/a >< open b", "socketcand:HOST:PORT/BUS was expected"},
           {"socketcand:127.0.0.1:29536/a_name_that_is_long", "BUS has 1 to 16 characters"},
           {"cannelloni:127.0.0.1:20000", "cannelloni:udp:HOST:PORT:LOCAL"},
           {"cannelloni:udp:127.0.0.1:20000:0", "'0' is no local UDP port; it is 1 to 65535"},
           {"cannelloni:udp:127.0.0.1:20000:x", "'x' is no local UDP port"}}) {
    const auto opened = open_can_port(row.text, {}, clock);
    ASSERT_FALSE(opened) << row.text;
    EXPECT_EQ(opened.error().code, CanPortErrorCode::kUsage) << row.text;
    EXPECT_THAT(opened.error().message, HasSubstr(row.part)) << row.text;
  }
}

TEST(OpenCanPort, ABitRateThatDoesNotExist) {
  rt::MonotonicClock clock;
  const auto opened = open_can_port("slcan:/dev/null", {.bit_rate = 300'000}, clock);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, CanPortErrorCode::kUsage);
  EXPECT_THAT(opened.error().message, HasSubstr("there is no bit rate of 300000 bit/s"));
}

TEST(OpenCanPort, NobodyListens) {
  rt::MonotonicClock clock;
  std::string address;
  {
    const Server server;
    address = server.address;
  }
  for (const std::string& text :
       {"slcan:tcp:" + address, "socketcand:" + address + "/can0", "cannelloni:tcp:" + address}) {
    const auto opened = open_can_port(text, {}, clock);
    ASSERT_FALSE(opened) << text;
    EXPECT_EQ(opened.error().code, CanPortErrorCode::kMachine);
    EXPECT_EQ(opened.error().message, "cannot connect to " + address + ": Connection refused.");
  }
}

}  // namespace
}  // namespace driveline::canopen
