// The mailbox gateway with network clients, in front of a simulated drive in PREOP.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/mailbox/mail_exchange.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/runtime/gateway/mailbox_gateway.hpp"
#include "driveline/runtime/setup/session.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "gateway/tcp_user.hpp"
#include "support/must.hpp"

namespace driveline::runtime {
namespace {

using Bytes = std::vector<int>;
using testing::SizeIs;

/// A service tool: a socket and hand-made bytes.
class Tool {
 public:
  Tool(int type, std::uint16_t port) : socket_(::socket(AF_INET, type, 0)) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port);
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{5, 0};
    ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0)
      throw std::runtime_error("connect");
  }
  void send(const Bytes& bytes) const {
    std::vector<std::uint8_t> raw(bytes.begin(), bytes.end());
    ASSERT_EQ(::send(socket_.get(), raw.data(), raw.size(), MSG_NOSIGNAL), static_cast<ssize_t>(raw.size()));
  }
  /// A datagram, or the available bytes of a stream; empty: none came, or the other side has closed.
  [[nodiscard]] Bytes receive() const {
    std::array<std::uint8_t, 4096> raw{};
    const auto length = ::recv(socket_.get(), raw.data(), raw.size(), 0);
    return length <= 0 ? Bytes{} : Bytes(raw.begin(), raw.begin() + length);
  }

 private:
  rt::FileDescriptor socket_;
};

/// EtherCAT header of type 5, mailbox header for `station` with counter 3.
Bytes mail(int station, int type, const Bytes& service) {
  const int length = static_cast<int>(service.size());
  Bytes bytes = {
      (length + 6) & 0xFF, ((length + 6) >> 8) | 0x50, length & 0xFF, length >> 8, station & 0xFF, station >> 8, 0x00,
      0x30 | type};
  bytes.insert(bytes.end(), service.begin(), service.end());
  return bytes;
}
const Bytes kUploadVendor = {0x00, 0x20, 0x40, 0x18, 0x10, 0x01, 0, 0, 0, 0};
constexpr int kStation = 0x1001;
constexpr int kCoe = 3;
constexpr int kFoe = 4;
constexpr int kSoe = 5;
/// Quick stop deceleration (6085h) = 1: after it, a drive hardly brakes.
const Bytes kDownload = {0x00, 0x20, 0x23, 0x85, 0x60, 0x00, 1, 0, 0, 0};
/// Every client on this machine may write.
GatewaySettings writable() {
  GatewaySettings settings;
  settings.write_addresses = {{127, 0, 0, 1}};
  return settings;
}

class Gateway : public testing::Test {
 protected:
  void SetUp() override {
    LineConfig config;
    config.slaves.resize(2);
    config.slaves[0].name = "x";
    config.slaves[1].name = "y";
    auto opened = must(Session::open(std::move(config), BusOptions{}));
    session_ = std::move(*opened);
    master_ = std::make_unique<ecat_master::Master>(session_->port(), session_->clock());
    ASSERT_TRUE(master_->scan());
    ASSERT_TRUE(master_->enter_pre_op());
  }
  void open(GatewaySettings settings = {}) {
    settings.port = 0;
    // The second slave is on the line, but not accessible to clients.
    auto opened = must(MailboxGateway::open(master_->mailboxes(), {master_->slaves()[0].info.ref}, settings));
    gateway_ = std::move(*opened);
    ASSERT_EQ(master_->slaves()[0].info.ref.station, kStation);
  }
  [[nodiscard]] Bytes ask(const Bytes& request) const {
    const Tool tool(SOCK_DGRAM, gateway_->port());
    tool.send(request);
    return tool.receive();
  }

  std::unique_ptr<Session> session_;
  std::unique_ptr<ecat_master::Master> master_;
  std::unique_ptr<MailboxGateway> gateway_;
};

/// The vendor of the drive, with station address and counter of the request.
const Bytes kVendorAnswer = {0x10, 0x50, 0x0A, 0x00, 0x01, 0x10, 0x00, 0x33, 0x00,
                             0x30, 0x43, 0x18, 0x10, 0x01, 0x3A, 0x00, 0x00, 0x00};

TEST_F(Gateway, CarriesAnSdoOverUdp) {
  open();
  const auto answer = ask(mail(kStation, kCoe, kUploadVendor));
  ASSERT_THAT(answer, SizeIs(18));
  const auto vendor = master_->slaves()[0].info.description.vendor_id;
  auto expected = kVendorAnswer;
  for (std::size_t i = 0; i < 4; ++i) expected[14 + i] = static_cast<int>((vendor >> (8 * i)) & 0xFFU);
  EXPECT_EQ(answer, expected);
  const auto clients = gateway_->clients();
  ASSERT_EQ(clients.size(), 1U);
  EXPECT_THAT(clients[0].name, testing::StartsWith("udp 127.0.0.1:"));
  EXPECT_EQ(clients[0].requests, 1U);
  EXPECT_EQ(clients[0].answers, 1U);
}

TEST_F(Gateway, CarriesMailsOfAStreamInTheirOrder) {
  open();
  const Tool tool(SOCK_STREAM, gateway_->port());
  auto both = mail(kStation, kCoe, kUploadVendor);
  const auto product = mail(kStation, kCoe, {0x00, 0x20, 0x40, 0x18, 0x10, 0x02, 0, 0, 0, 0});
  both.insert(both.end(), product.begin(), product.end());
  // Cut at arbitrary points, because a stream has no message boundaries.
  tool.send({both.begin(), both.begin() + 1});
  tool.send({both.begin() + 1, both.begin() + 25});
  tool.send({both.begin() + 25, both.end()});
  Bytes answers;
  while (answers.size() < 36) {
    const auto part = tool.receive();
    ASSERT_FALSE(part.empty());
    answers.insert(answers.end(), part.begin(), part.end());
  }
  EXPECT_EQ(answers[13], 1);
  EXPECT_EQ(answers[18 + 13], 2);
}

/// Lists of CoE and fragments of SoE announce further messages.
TEST(MailExchange, TakesEveryMailOfAnAnswer) {
  using Reaction = ecat_master::MailboxDialogue::Reaction;
  const auto mail_of = [](std::initializer_list<int> octets) {
    std::vector<std::byte> bytes;
    for (const int octet : octets) bytes.push_back(static_cast<std::byte>(octet));
    return bytes;
  };
  ecat_master::MailExchange list(wire::MailboxType::kCoe, {}, std::chrono::seconds{1});
  list.begin(0, {});
  EXPECT_EQ(list.receive(mail_of({0x00, 0x10, 0x30, 0x81, 0, 0, 0, 0, 0, 0})), Reaction::kForeign) << "an emergency";
  EXPECT_EQ(list.receive(mail_of({0x00, 0x80, 0x82, 0, 1, 0})), Reaction::kAwait);
  EXPECT_EQ(list.receive(mail_of({0x00, 0x80, 0x02, 0, 0, 0})), Reaction::kDone);
  EXPECT_THAT(*list.answers(), SizeIs(2));
  // The same bit in an SDO response is part of the data.
  ecat_master::MailExchange sdo(wire::MailboxType::kCoe, {}, std::chrono::seconds{1});
  sdo.begin(0, {});
  EXPECT_EQ(sdo.receive(mail_of({0x00, 0x30, 0x80, 0, 0x10, 1, 0, 0, 0, 0})), Reaction::kDone);
  ecat_master::MailExchange soe(wire::MailboxType::kSoe, {}, std::chrono::seconds{1});
  soe.begin(0, {});
  EXPECT_EQ(soe.receive(mail_of({0x0A, 0x40, 1, 0, 'x'})), Reaction::kAwait);
  EXPECT_EQ(soe.receive(mail_of({0x02, 0x40, 0, 0, 'y'})), Reaction::kDone);
  EXPECT_THAT(*soe.answers(), SizeIs(2));
}

TEST(MailExchange, AnAnswerWithoutEndEndsAtItsLimit) {
  using Reaction = ecat_master::MailboxDialogue::Reaction;
  using wire::MailboxType;
  // A list of CoE and a fragment of SoE that announce more, each with the least bytes that say so.
  const std::pair<MailboxType, std::vector<std::byte>> cases[] = {
      {MailboxType::kCoe, {std::byte{0x00}, std::byte{0x80}, std::byte{0x82}}},
      {MailboxType::kSoe, {std::byte{0x0A}}},
  };
  for (const auto& [type, service] : cases) {
    ecat_master::MailExchange exchange(type, {}, std::chrono::seconds{1});
    exchange.begin(3, {});
    using ecat_master::MailExchange;
    const std::size_t most = MailExchange::kLargest / (service.size() + MailExchange::kBytesPerMessage);
    std::size_t taken = 0;
    while (taken <= most && exchange.receive(service) == Reaction::kAwait) ++taken;
    EXPECT_EQ(taken, most);
    ASSERT_FALSE(exchange.answers());
    EXPECT_EQ(describe(exchange.answers().error()), "slave 3: sent a malformed mailbox");
  }
}

struct Refused {
  Bytes request;
  int code;
};

TEST_F(Gateway, RefusesWithAMailboxError) {
  open({.protocols = {wire::MailboxType::kCoe}});
  auto long_upload = kUploadVendor;
  long_upload.resize(1400);
  const std::vector<Refused> cases = {
      {mail(kStation, 4, {1, 0, 0, 0, 0, 0, 'a'}), 2},  // a protocol that does not pass
      {mail(kStation, 2, {0, 1, 0, 0}), 2},             // EoE never does
      {mail(kStation + 1, kCoe, kUploadVendor), 5},     // a slave that is not for clients
      {mail(0, kCoe, kUploadVendor), 5},                // the master itself
      {mail(kStation, kCoe, long_upload), 8},           // longer than the mailbox
      {mail(kStation, kCoe, {0x00}), 6},                // the slave's own refusal: too short
  };
  for (const auto& [request, code] : cases) {
    const auto answer = ask(request);
    ASSERT_THAT(answer, SizeIs(12));
    EXPECT_EQ(answer[7] & 0x0F, 0) << "a mailbox error";
    EXPECT_EQ(answer[7] >> 4, 3) << "the counter of the request";
    EXPECT_EQ(answer[8], 1);
    EXPECT_EQ(answer[10], code);
  }
}

/// No simulated drive knows VoE: its own refusal is returned.
TEST_F(Gateway, HandsOutTheRefusalOfTheSlave) {
  open(writable());
  const auto answer = ask(mail(kStation, 15, {0xAA, 0, 0, 0, 1, 0}));
  ASSERT_THAT(answer, SizeIs(12));
  EXPECT_EQ(answer[7] & 0x0F, 0);
  EXPECT_EQ(answer[10], 2);
  EXPECT_EQ(gateway_->clients()[0].refused, 1U);
}

TEST_F(Gateway, GarbageIsCountedAndHarmsNobody) {
  open();
  const Tool udp(SOCK_DGRAM, gateway_->port());
  auto wrong_type = mail(kStation, kCoe, kUploadVendor);
  wrong_type[1] = 0x10;
  auto longer = mail(kStation, kCoe, kUploadVendor);
  longer.push_back(0);
  auto beyond = mail(kStation, kCoe, kUploadVendor);
  beyond[2] = 0xFF;
  for (const auto& garbage : {Bytes{0x06}, wrong_type, longer, beyond, Bytes{0x02, 0x50, 0, 0}}) udp.send(garbage);
  const Tool tcp(SOCK_STREAM, gateway_->port());
  tcp.send({'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T', 'P'});
  EXPECT_EQ(tcp.receive(), Bytes{}) << "sent away";
  udp.send(mail(kStation, kCoe, kUploadVendor));
  EXPECT_THAT(udp.receive(), SizeIs(18));
  std::uint64_t malformed = 0;
  for (const auto& client : gateway_->clients()) malformed += client.malformed;
  EXPECT_EQ(malformed, 6U);
}

TEST_F(Gateway, OnlyReadsForAClientThatIsNotNamed) {
  open();
  const auto before = master_->mailboxes().statistics(0).sent;
  // The answers: an SDO abort "because of local control" with the object, a FoE error "no rights", a SoE error
  // "protected value", and a mailbox error "service not supported".
  EXPECT_EQ(ask(mail(kStation, kCoe, kDownload)),
            mail(kStation, kCoe, {0x00, 0x20, 0x80, 0x85, 0x60, 0x00, 0x21, 0x00, 0x00, 0x08}));
  EXPECT_EQ(ask(mail(kStation, kCoe, {0x00, 0x20, 0x21, 0x85, 0x60, 0x00, 4, 0, 0, 0, 1, 0, 0, 0})),
            mail(kStation, kCoe, {0x00, 0x20, 0x80, 0x85, 0x60, 0x00, 0x21, 0x00, 0x00, 0x08}));
  EXPECT_THAT(ask(mail(kStation, kCoe, {0x00, 0x20, 0x01, 1, 0, 0, 0, 0, 0, 0})), SizeIs(18)) << "a segment";
  const auto file = ask(mail(kStation, kFoe, {2, 0, 0, 0, 0, 0, 'a'}));
  ASSERT_GE(file.size(), 14U);
  EXPECT_EQ(Bytes(file.begin() + 8, file.begin() + 14), (Bytes{5, 0, 0x0A, 0x80, 0, 0}));
  EXPECT_EQ(ask(mail(kStation, kSoe, {3, 0x40, 47, 0, 1, 0})), mail(kStation, kSoe, {0x14, 0x40, 47, 0, 0x05, 0x70}));
  EXPECT_EQ(ask(mail(kStation, 15, {0xAA, 0, 0, 0, 1, 0})), mail(kStation, 0, {1, 0, 4, 0}));
  EXPECT_EQ(master_->mailboxes().statistics(0).sent, before) << "nothing has reached the slave";
  const auto writes = gateway_->take_writes();
  ASSERT_THAT(writes, SizeIs(1)) << "refusals do not fill the list of events";
  EXPECT_TRUE(writes[0].refused);
  EXPECT_EQ(writes[0].what, "6085h:0 = 0x00000001");
  EXPECT_THAT(ask(mail(kStation, kCoe, kUploadVendor)), SizeIs(18)) << "reading stays possible";
}

TEST_F(Gateway, EachDownloadOfANamedClientIsReported) {
  open(writable());
  const auto answer = ask(mail(kStation, kCoe, kDownload));
  ASSERT_THAT(answer, SizeIs(18));
  EXPECT_EQ(answer[10], 0x60) << "the drive has accepted it";
  EXPECT_THAT(ask(mail(kStation, kCoe, {0x00, 0x20, 0x2B, 0x5E, 0x60, 0x00, 2, 0, 0, 0})), SizeIs(18));
  EXPECT_THAT(ask(mail(kStation, kCoe, kUploadVendor)), SizeIs(18));
  const auto writes = gateway_->take_writes();
  ASSERT_THAT(writes, SizeIs(2));
  EXPECT_FALSE(writes[0].refused);
  EXPECT_EQ(writes[0].slave, 0);
  EXPECT_THAT(writes[0].client, testing::StartsWith("udp 127.0.0.1:"));
  EXPECT_EQ(writes[0].what, "6085h:0 = 0x00000001");
  EXPECT_EQ(writes[1].what, "605Eh:0 = 0x0002");
  EXPECT_THAT(gateway_->take_writes(), testing::IsEmpty());
}

/// The user is known for TCP only: a datagram may come from a process that has ended by now.
TEST_F(Gateway, ANamedUserWritesOverTcp) {
  GatewaySettings settings;
  settings.write_users = {::geteuid()};
  open(settings);
  const Tool tcp(SOCK_STREAM, gateway_->port());
  tcp.send(mail(kStation, kCoe, kDownload));
  const auto answer = tcp.receive();
  ASSERT_THAT(answer, SizeIs(18));
  EXPECT_EQ(answer[10], 0x60);
  EXPECT_EQ(ask(mail(kStation, kCoe, kDownload))[10], 0x80) << "over UDP";
}

TEST_F(Gateway, AnotherUserDoesNotWriteOverTcp) {
  GatewaySettings settings;
  settings.write_users = {::geteuid() + 1};
  open(settings);
  const Tool tcp(SOCK_STREAM, gateway_->port());
  tcp.send(mail(kStation, kCoe, kDownload));
  const auto answer = tcp.receive();
  ASSERT_THAT(answer, SizeIs(18));
  EXPECT_EQ(answer[10], 0x80);
}

sockaddr_in end_at(std::uint32_t address, std::uint16_t port) {
  sockaddr_in end{};
  end.sin_family = AF_INET;
  end.sin_addr.s_addr = htonl(address);
  end.sin_port = htons(port);
  return end;
}

/// Rows as Linux prints them on a little-endian machine.
TEST(GatewayUsers, AreThoseOfEstablishedConnections) {
  const auto client = end_at(INADDR_LOOPBACK, 40112);
  const auto server = end_at(INADDR_LOOPBACK, 34980);
  const auto user_in = [&](const std::string& rows) {
    std::istringstream table("  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n" +
                             rows);
    return find_tcp_user(table, client, server);
  };
  const std::string rest = " 00000000:00000000 00:00000000 00000000 ";
  EXPECT_EQ(user_in("   0: 0100007F:88A4 0100007F:9CB0 01" + rest +
                    " 0 0 1 1\n"
                    "   1: 0100007F:9CB0 0100007F:88A4 01" +
                    rest + " 1000 0 2 1\n"),
            std::optional<uid_t>(1000));
  EXPECT_EQ(user_in("   1: 0100007F:9CB0 0100007F:88A4 04" + rest + " 0 0 2 1\n"), std::nullopt) << "closed by its end";
  EXPECT_EQ(user_in("   1: 0100007F:9CB1 0100007F:88A4 01" + rest + " 1000 0 2 1\n"), std::nullopt) << "another port";
  EXPECT_EQ(user_in("   1: 0000000000000000FFFF00000100007F:9CB0 0000000000000000FFFF00000100007F:88A4 01" + rest +
                    " 1001 0 2 1\n"),
            std::optional<uid_t>(1001));
  EXPECT_EQ(user_in("garbage\n\n"), std::nullopt);
}

TEST_F(Gateway, SilentClientsDoNotShutOthersOut) {
  GatewaySettings settings;
  settings.silence = std::chrono::nanoseconds{0};
  open(settings);
  std::vector<std::unique_ptr<Tool>> silent;
  for (int i = 0; i < 16; ++i) silent.push_back(std::make_unique<Tool>(SOCK_STREAM, gateway_->port()));
  const Tool fresh(SOCK_STREAM, gateway_->port());
  fresh.send(mail(kStation, kCoe, kUploadVendor));
  EXPECT_THAT(fresh.receive(), SizeIs(18));
}

TEST_F(Gateway, AClientThatDoesNotCompleteItsMailIsDisconnected) {
  GatewaySettings settings;
  settings.silence = std::chrono::nanoseconds{0};
  open(settings);
  const Tool tool(SOCK_STREAM, gateway_->port());
  tool.send({0x10});
  EXPECT_EQ(tool.receive(), Bytes{});
  const auto clients = gateway_->clients();
  ASSERT_THAT(clients, SizeIs(1));
  EXPECT_EQ(clients[0].malformed, 1U);
}

TEST_F(Gateway, AnActiveClientKeepsItsPlace) {
  GatewaySettings settings;
  settings.silence = std::chrono::hours{1};
  open(settings);
  std::vector<std::unique_ptr<Tool>> tools;
  for (int i = 0; i < 16; ++i) {
    tools.push_back(std::make_unique<Tool>(SOCK_STREAM, gateway_->port()));
    tools.back()->send(mail(kStation, kCoe, kUploadVendor));
    ASSERT_THAT(tools.back()->receive(), SizeIs(18));
  }
  const Tool fresh(SOCK_STREAM, gateway_->port());
  EXPECT_EQ(fresh.receive(), Bytes{}) << "there is no place";
  tools[0]->send(mail(kStation, kCoe, kUploadVendor));
  EXPECT_THAT(tools[0]->receive(), SizeIs(18));
}

/// Each datagram comes from another client; the slave is silent, so all requests stay in flight.
TEST_F(Gateway, ManyClientsGetNoMoreThanTheLimitOfAll) {
  open();
  ASSERT_TRUE(session_->simulated_line()->inject({.kind = slaves::FaultKind::kMailboxSilent, .slave = 0}));
  std::vector<std::unique_ptr<Tool>> tools;
  for (int i = 0; i < 80; ++i) {
    tools.push_back(std::make_unique<Tool>(SOCK_DGRAM, gateway_->port()));
    tools.back()->send(mail(kStation, kCoe, kUploadVendor));
  }
  // Requests above the limit are refused at once; the last one is among them.
  const auto answer = tools.back()->receive();
  ASSERT_THAT(answer, SizeIs(12));
  EXPECT_EQ(answer[10], 9);
}

TEST_F(Gateway, OwnTransfersGoOnBesideIt) {
  open();
  const Tool tool(SOCK_DGRAM, gateway_->port());
  auto* mailbox = master_->mailbox(0);
  for (int i = 0; i < 20; ++i) {
    tool.send(mail(kStation, kCoe, kUploadVendor));
    ecat_master::CoeClient coe(*mailbox);
    const auto product = must(coe.upload_as<std::uint32_t>(0x1018, 2));
    EXPECT_EQ(*product, master_->slaves()[0].info.description.product_code);
    EXPECT_EQ(tool.receive()[13], 1);
  }
}

/// Reads a file like a tool, up to the acknowledge of the last packet; returns the number of packets.
int read_file(const Tool& tool, const std::string& name) {
  Bytes request = {1, 0, 0, 0, 0, 0};
  request.insert(request.end(), name.begin(), name.end());
  tool.send(mail(kStation, kFoe, request));
  for (int packet = 1;; ++packet) {
    const auto answer = tool.receive();
    if (answer.size() < 14 || answer[8] != 3) return -1;
    tool.send(mail(kStation, kFoe, {4, 0, packet & 0xFF, packet >> 8, 0, 0}));
    constexpr std::size_t kFull = 2 + slaves::msd::kMailboxSize;
    if (answer.size() < kFull) return packet;
  }
}

TEST_F(Gateway, WaitsForNoAnswerToWhatNobodyAnswers) {
  open();
  const Tool tool(SOCK_DGRAM, gateway_->port());
  EXPECT_GT(read_file(tool, "parameters.txt"), 1);
  tool.send(mail(kStation, kCoe, {0x00, 0x20, 0x80, 0x18, 0x10, 0x01, 0, 0, 0x04, 0x05}));  // an SDO abort
  tool.send(mail(kStation, 4, {5, 0, 0, 0x80, 0, 0}));                                      // a FoE error
  tool.send(mail(kStation, kCoe, kUploadVendor));
  EXPECT_THAT(tool.receive(), SizeIs(18));
  EXPECT_EQ(master_->mailboxes().statistics(0).timeouts, 0U);
}

TEST_F(Gateway, APortThatIsTakenIsAnError) {
  open();
  EXPECT_THAT(failure_text(MailboxGateway::open(master_->mailboxes(), {}, {.port = gateway_->port()})),
              testing::HasSubstr("cannot listen: Address already in use"));
}

}  // namespace
}  // namespace driveline::runtime
