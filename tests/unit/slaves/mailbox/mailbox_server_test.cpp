#include "driveline/slaves/mailbox/mailbox_server.hpp"

#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Bytes kReadByte = {0x0A, 0, 0, 0, 0, 0x13, 0x00, 0x20, 0x40, 0x00, 0x20, 0x00, 0, 0, 0, 0};

TEST(MailboxServer, AnswersWithItsOwnCounterAndTheMastersAddress) {
  MailboxRig rig;
  rig.write(kReadByte);
  // Header of the shape a real drive answers with (soem-sdinfo-akd, packet 290): length 10, address 0, CoE, counter 1.
  EXPECT_THAT(rig.read(), ElementsAre(0x0A, 0, 0, 0, 0, 0x13, 0x00, 0x30, 0x4F, 0x00, 0x20, 0x00, 0x11, 0, 0, 0));
  EXPECT_THAT(rig.read(), IsEmpty());
  for (unsigned n = 2; n <= 15; ++n) {
    auto request = kReadByte;
    request[5] = 0x03 | ((n - 1) % 7 + 1) << 4;
    rig.write(request);
    EXPECT_EQ(rig.read()[5], 0x03 | ((n - 1) % 7 + 1) << 4);  // 1..7 and round again, never 0
  }
}

TEST(MailboxServer, AnswersWithTheAddressOfTheSlaveThatAsked) {
  MailboxRig rig;
  auto request = kReadByte;
  request[2] = 0x03;
  request[3] = 0x10;
  rig.write(request);
  EXPECT_THAT(rig.read(), ElementsAre(0x0A, 0, 0x03, 0x10, 0, 0x13, 0x00, 0x30, 0x4F, 0x00, 0x20, 0x00, 0x11, 0, 0, 0));
  // VoE is not supported: mailbox error 2.
  rig.write({0x02, 0, 0x04, 0x10, 0, 0x2F, 1, 2});
  EXPECT_THAT(rig.read(), ElementsAre(4, 0, 0x04, 0x10, 0, 0x20, 1, 0, 2, 0));
  rig.coe_server.raise({0x3210, 1, {}});
  EXPECT_EQ(rig.read().at(2), 0U) << "an emergency is for the master";
}

TEST(MailboxServer, DropsARepeatedRequest) {
  MailboxRig rig;
  rig.write(kReadByte);
  rig.write(kReadByte);
  EXPECT_EQ(rig.server.repeated(), 1U);
  EXPECT_FALSE(rig.read().empty());
  EXPECT_TRUE(rig.read().empty());
}

TEST(MailboxServer, CounterZeroIsNeverARepetition) {
  MailboxRig rig;
  auto request = kReadByte;
  request[5] = 0x03;
  rig.write(request);
  rig.write(request);
  EXPECT_FALSE(rig.read().empty());
  EXPECT_FALSE(rig.read().empty());
  EXPECT_EQ(rig.server.repeated(), 0U);
}

TEST(MailboxServer, ForgetsTheCounterWhenTheMailboxIsRestarted) {
  MailboxRig rig;
  rig.write(kReadByte);
  EXPECT_FALSE(rig.read().empty());
  rig.server.reset();
  rig.write(kReadByte);
  EXPECT_EQ(rig.read().at(5), 0x13U);
}

struct ErrorCase {
  const char* name;
  Bytes mailbox;
  unsigned code;
};

TEST(MailboxServer, RepliesWithMailboxErrors) {
  // ETG.1000.4 Table 30: 2 unsupported protocol, 4 service not supported, 6 too short, 8 invalid size.
  const std::vector<ErrorCase> cases = {
      {"EoE", {0x04, 0, 0, 0, 0, 0x12, 0, 0, 0, 0}, 2},
      {"FoE", {0x06, 0, 0, 0, 0, 0x14, 1, 0, 0, 0, 0, 0}, 2},
      {"VoE", {0x02, 0, 0, 0, 0, 0x1F, 0, 0}, 2},
      {"length beyond the mailbox", {0xFB, 0x01, 0, 0, 0, 0x13}, 8},
      {"greatest length", {0xFF, 0xFF, 0, 0, 0, 0x13}, 8},
      {"no CoE header", {0x01, 0, 0, 0, 0, 0x13, 0}, 6},
      {"empty", {0x00, 0, 0, 0, 0, 0x13}, 6},
      {"SDO without its eight bytes", {0x09, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0, 0x20, 0, 0, 0, 0}, 6},
      {"SDO information without its header", {0x05, 0, 0, 0, 0, 0x13, 0, 0x80, 1, 0, 0}, 6},
      {"RxPDO over CoE", {0x0A, 0, 0, 0, 0, 0x13, 0, 0x50, 0, 0, 0, 0, 0, 0, 0, 0}, 4},
      {"SDO response from the master", {0x0A, 0, 0, 0, 0, 0x13, 0, 0x30, 0x40, 0, 0x20, 0, 0, 0, 0, 0}, 4},
      {"reserved CoE service", {0x0A, 0, 0, 0, 0, 0x13, 0, 0xF0, 0, 0, 0, 0, 0, 0, 0, 0}, 4},
  };
  for (const auto& c : cases) {
    MailboxRig rig;
    rig.write(c.mailbox);
    EXPECT_THAT(rig.read(), ElementsAre(4, 0, 0, 0, 0, 0x10, 1, 0, c.code, 0)) << c.name;
    EXPECT_TRUE(rig.read().empty()) << c.name;
  }
}

TEST(MailboxServer, AnswersNoErrorReply) {
  MailboxRig rig;
  rig.write({0x04, 0, 0, 0, 0, 0x10, 1, 0, 2, 0});
  EXPECT_TRUE(rig.read().empty());
  rig.write({0x04, 0, 0, 0, 0, 0x22, 0, 0, 0, 0});
  EXPECT_FALSE(rig.read().empty()) << "what comes behind it";
}

TEST(MailboxServer, ServesRequestsInOrderAndCountsWhatIsTooMuch) {
  MailboxRig rig;
  for (unsigned i = 1; i <= 6; ++i) {
    auto request = kReadByte;
    request[5] = 0x03 | i << 4;
    request[9] = i - 1;  // 2000h, 2001h, ...
    rig.write(request);
  }
  EXPECT_EQ(rig.server.dropped(), 6 - MailboxServer::kQueueDepth);
  for (unsigned i = 0; i < MailboxServer::kQueueDepth; ++i) EXPECT_EQ(rig.read().at(9), i);
  EXPECT_TRUE(rig.read().empty());
}

TEST(MailboxServer, ResetForgetsWaitingRequestsAndEmergencies) {
  MailboxRig rig;
  rig.write(kReadByte);
  rig.coe_server.raise({.error_code = 0xFF00});
  rig.server.reset();
  EXPECT_TRUE(rig.read().empty());
}

TEST(MailboxServer, TooSmallAReplyMailboxGivesNothing) {
  MailboxRig rig;
  rig.write(kReadByte);
  std::array<std::byte, 6> out{};
  EXPECT_EQ(rig.server.reply(out, wire::AlState::kPreOp), 0U);
}

TEST(CoeServer, EmergenciesComeFirstAndInOrder) {
  MailboxRig rig;
  rig.write(kReadByte);
  rig.coe_server.raise({0xFF00, 0x11, {std::byte{14}, std::byte{1}, std::byte{2}, std::byte{0}, std::byte{0}}});
  rig.coe_server.raise({});
  EXPECT_THAT(rig.read(),
              ElementsAre(0x0A, 0, 0, 0, 0, 0x13, 0x00, 0x10, 0x00, 0xFF, 0x11, 0x0E, 0x01, 0x02, 0x00, 0x00));
  EXPECT_THAT(rig.read(), ElementsAre(0x0A, 0, 0, 0, 0, 0x23, 0x00, 0x10, 0, 0, 0, 0, 0, 0, 0, 0));
  EXPECT_EQ(rig.read().at(7), 0x30U);
}

TEST(CoeServer, KeepsTheLatestEmergencies) {
  MailboxRig rig;
  for (std::uint16_t i = 0; i < 10; ++i) rig.coe_server.raise({.error_code = i});
  EXPECT_EQ(rig.coe_server.lost_emergencies(), 2U);
  for (unsigned i = 2; i < 10; ++i) EXPECT_EQ(rig.read().at(8), i);
  EXPECT_TRUE(rig.read().empty());
}

}  // namespace
}  // namespace driveline::slaves
