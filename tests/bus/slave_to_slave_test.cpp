// Mailbox messages that a slave addresses to another slave, or that ask the master for something (ETG.1000.4 5.6: the
// address in the header is that of the destination when a slave asks, and that of the source when it is asked).
#include <gmock/gmock.h>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/mailbox/mail_exchange.hpp"
#include "edited_line.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
using ecat_master::MailExchange;
using ecat_master::Master;
using testing::ElementsAre;
using Mail = std::vector<std::byte>;

/// A mailbox message without a counter: length, address, channel and priority 0, type.
Mail mail_to(unsigned address, std::uint8_t type, std::initializer_list<unsigned> service) {
  Mail bytes;
  for (const std::size_t byte : {service.size(), std::size_t{0}, std::size_t{address & 0xFFU},
                                 std::size_t{address >> 8}, std::size_t{0}, std::size_t{type}}) {
    bytes.push_back(static_cast<std::byte>(byte));
  }
  for (const auto byte : service) bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

/// SDO upload request of 1018h:02, and of an object that no drive has.
Mail asks_product(unsigned address) {
  return mail_to(address, 3, {0x00, 0x20, 0x40, 0x18, 0x10, 0x02, 0, 0, 0, 0});
}
Mail asks_nothing(unsigned address) {
  return mail_to(address, 3, {0x00, 0x20, 0x40, 0xFF, 0x5F, 0x07, 0, 0, 0, 0});
}

/// Three drives in PREOP. The first one sends what a test gives it to say; what it hears stays with the test.
class AskingLine {
 public:
  AskingLine() : drives_(3), master_(drives_.line(), drives_.clock) {
    EXPECT_EQ(sentence(master_.scan()), "");
    EXPECT_EQ(sentence(master_.enter_pre_op()), "");
    asking().swallows = [this](std::span<const std::byte> mailbox) {
      const auto header = wire::MailboxHeader::decode(mailbox).value();
      Mail mail(mailbox.begin(), mailbox.begin() + static_cast<std::ptrdiff_t>(6 + header.length));
      mail[5] &= std::byte{0x0F};  // without the counter
      const bool own = header.type == wire::MailboxType::kCoe && header.address == 0;
      if (!own) heard.push_back(std::move(mail));
      return !own;
    };
  }

  [[nodiscard]] Master& master() noexcept { return master_; }
  [[nodiscard]] EditedLine& drives() noexcept { return drives_; }
  [[nodiscard]] EditedDevice& asking() noexcept { return drives_.device(0); }
  /// Lets the messages travel.
  void exchange() {
    for (int i = 0; i < 20; ++i) {
      for (std::uint16_t slave = 0; slave < 3; ++slave) ASSERT_EQ(sentence(master_.mailboxes().poll(slave)), "");
    }
  }
  /// Messages that the first drive got, except requests of the master.
  std::vector<Mail> heard;

 private:
  EditedLine drives_;
  Master master_;
};

constexpr std::uint16_t kThird = 0x1003;

TEST(SlaveToSlave, ARequestGoesToTheAddressedSlaveAndItsAnswerBack) {
  AskingLine line;
  line.asking().says_first = {asks_product(kThird), asks_nothing(kThird)};
  line.exchange();
  ASSERT_EQ(line.heard.size(), 2U);
  const auto code = bytes::to_le_bytes(slaves::msd::kProductCode);
  auto answer = mail_to(kThird, 3, {0x00, 0x30, 0x43, 0x18, 0x10, 0x02});
  answer[0] = std::byte{10};
  answer.insert(answer.end(), code.begin(), code.end());
  EXPECT_EQ(line.heard[0], answer);
  // 0602 0000h: the object does not exist. The specification lets a slave send its abort as a request.
  EXPECT_THAT(line.heard[1], testing::AnyOf(mail_to(kThird, 3, {0, 0x20, 0x80, 0xFF, 0x5F, 7, 0, 0, 2, 6}),
                                            mail_to(kThird, 3, {0, 0x30, 0x80, 0xFF, 0x5F, 7, 0, 0, 2, 6})));
  EXPECT_EQ(line.master().mailboxes().statistics(0).forwarded, 2U);
  EXPECT_EQ(line.master().mailboxes().statistics(2).forwarded, 2U) << "the answers";
  EXPECT_EQ(line.master().mailboxes().statistics(1).received, 0U);
}

TEST(SlaveToSlave, DoesNotDisturbTheTransfersOfTheMaster) {
  AskingLine line;
  for (int i = 0; i < 10; ++i) {
    line.asking().says_first = {asks_product(kThird)};
    for (const std::uint16_t slave : {std::uint16_t{0}, std::uint16_t{2}}) {
      const auto vendor = CoeClient(line.master().mailboxes(), slave).upload_as<std::uint32_t>(0x1018, 1);
      ASSERT_EQ(sentence(vendor), "");
      ASSERT_EQ(*vendor, 0x28U) << slave;
    }
  }
  line.exchange();
  EXPECT_EQ(line.heard.size(), 10U);
}

TEST(SlaveToSlave, ToAnAddressThatNobodyHasIsRefused) {
  AskingLine line;
  constexpr unsigned kNobody = 0x1234;
  line.asking().says_first = {asks_product(kNobody)};
  line.exchange();
  // Mailbox error reply (type 0): 1, then 5, invalid header (ETG.1000.4 Table 30).
  EXPECT_THAT(line.heard, ElementsAre(mail_to(kNobody, 0, {1, 0, 5, 0})));
  EXPECT_EQ(line.master().mailboxes().statistics(0).refused, 1U);
}

TEST(SlaveToSlave, BeyondTheRoomOfTheAddressedSlaveIsRefused) {
  AskingLine line;
  line.drives().slave(2).mailbox().set_fault(slaves::MailboxTransport::Fault::kBusy);
  line.asking().says_first.assign(12, asks_product(kThird));
  line.exchange();
  // 7: no more memory.
  EXPECT_THAT(line.heard, testing::Contains(mail_to(kThird, 0, {1, 0, 7, 0})));
  EXPECT_GE(line.master().mailboxes().statistics(0).forwarded, ecat_master::MailboxChannel::kMaxForwarded);
  EXPECT_LT(line.master().mailboxes().statistics(0).forwarded, 12U);
}

TEST(SlaveToSlave, AnErrorReplyIsNeverAnsweredWithOne) {
  AskingLine line;
  line.drives().slave(2).mailbox().set_fault(slaves::MailboxTransport::Fault::kBusy);
  line.asking().says_first.assign(12, mail_to(kThird, 0, {1, 0, 2, 0}));
  line.asking().says_first.push_back(mail_to(0x1234, 0, {1, 0, 2, 0}));
  line.exchange();
  EXPECT_TRUE(line.heard.empty());
  EXPECT_GE(line.master().mailboxes().statistics(0).refused, 1U);
}

TEST(SlaveToMaster, ARequestIsRefusedAsAServiceThatIsNotSupported) {
  // An SDO upload, an SDO information request for a list of objects, and an SDO download.
  for (const auto& request : {asks_product(0), mail_to(0, 3, {0x00, 0x80, 0x01, 0, 0, 0, 1, 0}),
                              mail_to(0, 3, {0x00, 0x20, 0x2F, 0x60, 0x60, 0, 8, 0, 0, 0})}) {
    AskingLine line;
    line.asking().says_first = {request};
    line.exchange();
    // 4: service not supported.
    EXPECT_THAT(line.heard, ElementsAre(mail_to(0, 0, {1, 0, 4, 0})));
  }
}

TEST(SlaveToMaster, ASlaveThatAsksAgainAfterEachRefusalDoesNotFillItsMailbox) {
  AskingLine line;
  line.asking().hears = [&](std::span<const std::byte> mailbox) {
    if ((mailbox[5] & std::byte{0x0F}) == std::byte{0}) line.asking().says_first = {asks_product(0)};
  };
  line.asking().says_first = {asks_product(0), asks_product(0)};
  const auto begin = line.drives().clock.now();
  while (line.drives().clock.now() < begin + milliseconds{950}) {
    ASSERT_EQ(sentence(CoeClient(line.master().mailboxes(), 0).upload(0x1018, 1)), "");
    line.drives().clock.sleep_until(line.drives().clock.now() + milliseconds{10});
  }
  EXPECT_THAT(line.heard.size(), testing::AllOf(testing::Ge(1U), testing::Le(10U)));
}

TEST(SlaveToMaster, ARequestIsNotTheAnswerToARawService) {
  AskingLine line;
  line.asking().says_first = {asks_product(0)};
  const Mail service{std::byte{0x00}, std::byte{0x20}, std::byte{0x40}, std::byte{0x18}, std::byte{0x10},
                     std::byte{0x01}, std::byte{0},    std::byte{0},    std::byte{0},    std::byte{0}};
  const auto exchange = std::make_shared<MailExchange>(wire::MailboxType::kCoe, service, milliseconds{500});
  line.master().mailboxes().submit(0, exchange);
  line.master().mailboxes().wait(*exchange);
  ASSERT_EQ(sentence(exchange->answers()), "");
  ASSERT_EQ(exchange->answers()->size(), 1U);
  EXPECT_EQ(exchange->answers()->front().at(1), std::byte{0x30}) << "an SDO response";
}

}  // namespace
}  // namespace driveline::bus_test
