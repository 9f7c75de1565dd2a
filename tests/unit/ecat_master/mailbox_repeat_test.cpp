// Requests that are sent again because no answer arrives, and answers whose mailbox counter repeats.
#include <gmock/gmock.h>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "support/mail_bench.hpp"
#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::MailBench;
using std::chrono::milliseconds;
using testing::ElementsAre;
using Bytes = std::vector<std::byte>;
using Mails = std::vector<Bytes>;

constexpr std::uint16_t kPosition = 3;

/// A slave whose mailbox content the test defines, and a client with these time-outs.
struct RepeatBench : MailBench {
  explicit RepeatBench(const MailboxTimeouts& timeouts = {}) : MailBench(wire::MailboxType::kCoe, 64, 64, timeouts) {
    mailbox.engine().handle(wire::MailboxType::kCoe, emergencies);
  }
  [[nodiscard]] MailboxStatistics statistics() { return mailbox.engine().statistics(kPosition); }

  EmergencyLog emergencies;
  CoeClient coe{mailbox};
};

// Headers: length, address 0, channel and priority 0, counter and type CoE (ETG.1000.4 5.6). SDO services:
// ETG.1000.6 5.6.2.
const Bytes kRequestOfCounter1 = hex("0A00 0000 00 13 0020 40 4160 02 00000000");
const Bytes kRequestOfCounter2 = hex("0A00 0000 00 23 0020 40 4160 02 00000000");
const Bytes kAnswer = hex("0A00 0000 00 13 0030 4F 4160 02 2A000000");

TEST(RequestWithoutAnswer, IsSentAgainWithItsCounterAndLastWithANewOne) {
  RepeatBench bench;
  EXPECT_EQ(failure_text(bench.coe.upload(0x6041, 2)), "slave 3: no mailbox reply for object 6041h:02 within 2000 ms");
  // 0504 0000h: the protocol timed out.
  const auto abort = hex("0A00 0000 00 33 0020 80 4160 02 00000405");
  EXPECT_THAT(bench.slave.requests,
              ElementsAre(kRequestOfCounter1, kRequestOfCounter1, kRequestOfCounter1, kRequestOfCounter2, abort));
  EXPECT_EQ(bench.statistics().resent, 3U);
  EXPECT_GE(bench.slave.now(), milliseconds{2000});
  EXPECT_LT(bench.slave.now(), milliseconds{2200}) << "the time-out starts with the first request";
}

TEST(RequestWithoutAnswer, IsAnsweredWhenTheSlaveIsNoLongerDeaf) {
  RepeatBench bench;
  bench.slave.answers = {Mails{}, Mails{}, Mails{kAnswer}};
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 2).value(), 0x2A);
  EXPECT_EQ(bench.slave.requests.size(), 3U);
  EXPECT_EQ(bench.statistics().resent, 2U);
  EXPECT_GE(bench.slave.now(), milliseconds{1000});
  EXPECT_LT(bench.slave.now(), milliseconds{1100});
}

TEST(RequestWithoutAnswer, HasTheIntervalOfTheSlave) {
  RepeatBench bench({.request = {}, .response = milliseconds{700}, .repeat = milliseconds{30}});
  bench.slave.answers = {Mails{}, Mails{}, Mails{kAnswer}};
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 2).value(), 0x2A);
  EXPECT_GE(bench.slave.now(), milliseconds{60});
  EXPECT_LT(bench.slave.now(), milliseconds{70});
}

TEST(RequestWithoutAnswer, IsSentOnceWhereThatIsPlanned) {
  RepeatBench bench({.request = {}, .response = {}, .repeat = milliseconds{0}});
  EXPECT_TRUE(bench.coe.upload(0x6041, 2).error().is<facts::MailboxTimeout>());
  EXPECT_EQ(bench.slave.requests.size(), 2U) << "the request and its abort";
  EXPECT_EQ(bench.statistics().resent, 0U);
}

TEST(RequestWithoutAnswer, WaitsUntilTheMailboxHasBeenReadEmpty) {
  RepeatBench bench({.request = {}, .response = milliseconds{50}, .repeat = milliseconds{5}});
  std::uint8_t counter = 0;
  // The next message is always there when the last one has been read.
  bench.slave.endless = [&] {
    counter = wire::next_mailbox_counter(counter);
    auto mail = hex("0A00 0000 00 03 0010 2032 05 0501000000");
    mail[5] = static_cast<std::byte>(counter << 4 | 3);
    return mail;
  };
  EXPECT_TRUE(bench.coe.upload(0x6041, 2).error().is<facts::MailboxTimeout>());
  EXPECT_EQ(bench.statistics().resent, 0U);
}

TEST(RequestWithoutAnswer, IsNotRepeatedAsASegment) {
  RepeatBench bench;
  // 20 bytes are announced, two arrive.
  bench.slave.answers = {Mails{hex("0C00 0000 00 13 0030 41 0810 00 14000000 0001")}};
  EXPECT_TRUE(bench.coe.upload(0x1008, 0).error().is<facts::MailboxTimeout>());
  EXPECT_EQ(bench.slave.requests.size(), 3U) << "the request, one segment, the abort";
}

TEST(RequestWithoutAnswer, IsRepeatedAsSdoInformation) {
  RepeatBench bench;
  // Object description (ETG.1000.6 5.6.3.4): 6041h, UNSIGNED16, no sub-index, variable, "S".
  bench.slave.answers = {Mails{}, Mails{hex("0D00 0000 00 13 0080 04 00 0000 4160 0600 00 07 53")}};
  const auto object = bench.coe.object_description(0x6041);
  ASSERT_TRUE(object);
  EXPECT_EQ(object->name, "S");
  EXPECT_EQ(bench.slave.requests.size(), 2U);
}

/// An SDO answer with counter 1: `value` of 6041h:02.
Bytes answer_of(std::uint8_t value) {
  auto mail = kAnswer;
  mail[12] = static_cast<std::byte>(value);
  return mail;
}

TEST(ConstantMailboxCounter, DoesNotHideAnswers) {
  RepeatBench bench;
  const std::uint8_t values[] = {7, 9, 9, 11, 11};
  for (const auto value : values) bench.slave.answers.push_back({answer_of(value)});
  for (const auto value : values) EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 2).value(), value);
  EXPECT_EQ(bench.slave.requests.size(), std::size(values));
  EXPECT_EQ(bench.statistics().same_counter, 4U);
  EXPECT_EQ(bench.statistics().repetitions, 0U);
  EXPECT_LT(bench.slave.now(), milliseconds{10}) << "without a repeated request";
}

TEST(ConstantMailboxCounter, WithTheSameAnswerAgainIsBelievedWhenTheRequestWasRepeated) {
  RepeatBench bench;
  for (int i = 0; i < 4; ++i) bench.slave.answers.push_back({answer_of(7)});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 2).value(), 7) << i;
  EXPECT_EQ(bench.slave.requests.size(), 4U) << "only the second one is repeated";
  EXPECT_EQ(bench.statistics().repetitions, 1U);
  EXPECT_EQ(bench.statistics().same_counter, 2U);
}

TEST(ConstantMailboxCounter, IsInTheSentenceWhereRequestsAreNotRepeated) {
  RepeatBench bench({.request = {}, .response = {}, .repeat = milliseconds{0}});
  for (int i = 0; i < 2; ++i) bench.slave.answers.push_back({answer_of(7)});
  ASSERT_TRUE(bench.coe.upload(0x6041, 2));
  const auto read = bench.coe.upload(0x6041, 2);
  ASSERT_FALSE(read);
  EXPECT_EQ(describe(read.error()),
            "slave 3: no mailbox reply for object 6041h:02 within 2000 ms; 1 reply was dropped, with the counter and "
            "content of the previous message");
}

TEST(ConstantMailboxCounter, DoesNotHideEmergencies) {
  RepeatBench bench;
  bench.slave.answers.push_back(
      {hex("0A00 0000 00 13 0010 2032 05 0501000000"), hex("0A00 0000 00 13 0010 1023 09 0501000000"), answer_of(7)});
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 2).value(), 7);
  EXPECT_EQ(bench.emergencies.take(kPosition).size(), 2U);
}

}  // namespace
}  // namespace driveline::ecat_master
