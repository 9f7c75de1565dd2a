#include "driveline/canopen_client/sdo_client.hpp"

#include <array>

#include "scripted_port.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

/// Node 1, whose requests are on 601h and answers on 581h.
class SdoClientTest : public ScriptedBus {
 protected:
  SdoClient client{link, 1};

  /// The error of an upload of 2003h:00.
  ClientError upload_error() {
    const auto data = client.upload({0x2003, 0});
    EXPECT_FALSE(data);
    return data ? ClientError{} : data.error();
  }
};

// The 30 frames of MSD manual 8.2.4; its pauses of 16.5 s and 9.2 s are the master's.
TEST_F(SdoClientTest, UploadsTheTraceOfTheManual) {
  port.answer("581#4103200064000000");
  port.answer("581#00582D4178697300");
  for (int i = 2; i <= 14; ++i) port.answer(i % 2 == 0 ? "581#1000000000000000" : "581#0000000000000000");
  port.answer("581#0B00000000000000");
  const auto data = must(client.upload({0x2003, 0}));
  ASSERT_EQ(data->size(), 100U);
  EXPECT_EQ(bytes_test::copy_of(std::span(*data).first(7)), hex("58 2D 41 78 69 73 00"));
  ASSERT_EQ(port.sent.size(), 16U);
  EXPECT_EQ(port.sent[0], "601#4003200000000000");
  for (std::size_t i = 1; i < 16; ++i)
    EXPECT_EQ(port.sent[i], i % 2 == 1 ? "601#6000000000000000" : "601#7000000000000000");
}

// CiA 301 7.2.4.3.6: n counts the bytes of d that hold no data; without s there are four.
TEST_F(SdoClientTest, ExpeditedUploadsOfAllSizes) {
  for (const auto& [answer, value] :
       {std::pair{"581#4F606000FF000000", "FF"}, std::pair{"581#4B416000373A0000", "373A"},
        std::pair{"581#4703200001020300", "010203"}, std::pair{"581#4300100092010200", "92010200"},
        std::pair{"581#4200100092010200", "92010200"}}) {
    const auto frame = *candump::parse_frame(answer);
    const auto message = *SdoMessage::decode(frame.payload());
    port.answer(answer);
    EXPECT_EQ(*must(client.upload({message.index, message.subindex})), hex(value)) << answer;
  }
  port.answer("581#4B416000373A0000");
  EXPECT_EQ(*must(client.upload_number({0x6041, 0})), 0x3A37U);
}

TEST_F(SdoClientTest, DownloadsExpedited) {
  port.answer("581#6060600000000000");
  EXPECT_TRUE(client.download_number({0x6060, 0}, 7, 1));
  port.answer("581#6040600000000000");
  EXPECT_TRUE(client.download_number({0x6040, 0}, 0x000F, 2));
  EXPECT_THAT(port.sent, ElementsAre("601#2F60600007000000", "601#2B4060000F000000"));
}

// CiA 301 7.2.4.3.3 and .4: size, toggle in bit 4, unused bytes in bits 1-3, last in bit 0.
TEST_F(SdoClientTest, DownloadsInSegments) {
  port.answer("581#6003200000000000");
  port.answer("581#2000000000000000");
  port.answer("581#3000000000000000");
  EXPECT_TRUE(client.download({0x2003, 0}, hex("01 02 03 04 05 06 07 08")));
  EXPECT_THAT(port.sent, ElementsAre("601#2103200008000000", "601#0001020304050607", "601#1D08000000000000"));
}

TEST_F(SdoClientTest, DownloadsNothing) {
  port.answer("581#6003200000000000");
  port.answer("581#2000000000000000");
  EXPECT_TRUE(client.download({0x2003, 0}, {}));
  EXPECT_THAT(port.sent, ElementsAre("601#2103200000000000", "601#0F00000000000000"));
}

TEST_F(SdoClientTest, AnAbortOfTheNodeIsItsError) {
  port.answer("581#8003200000000206");
  auto error = upload_error();
  EXPECT_EQ(error.kind, ClientErrorKind::kAborted);
  EXPECT_EQ(error.code, SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(describe(error),
            "node 1: object 0x2003:00 aborted with 0x06020000 (object does not exist in the object dictionary)");
  port.answer("581#6003200000000000");
  port.answer("581#8000000000000806");  // a server that does not name the object
  const auto done = client.download({0x2003, 0}, hex("01 02 03 04 05"));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ClientErrorKind::kAborted);
  EXPECT_EQ(port.sent.size(), 3U) << "an abort has no answer";
}

TEST_F(SdoClientTest, AWrongToggleBitEndsTheTransfer) {
  port.answer("581#4103200064000000");
  port.answer("581#1001020304050607");
  const auto error = upload_error();
  EXPECT_EQ(error.kind, ClientErrorKind::kBadAnswer);
  EXPECT_EQ(error.code, SdoAbort::kToggleNotAlternated);
  EXPECT_EQ(port.sent.back(), "601#8003200000000305");
  port.answer("581#6003200000000000");
  port.answer("581#3000000000000000");
  EXPECT_EQ(client.download({0x2003, 0}, hex("0102030405")).error().code, SdoAbort::kToggleNotAlternated);
  EXPECT_EQ(port.sent.back(), "601#8003200000000305");
}

TEST_F(SdoClientTest, ASizeThatLiesIsRefused) {
  port.answer("581#4103200003000000");
  port.answer("581#0001020304050607");
  auto error = upload_error();
  EXPECT_EQ(error.code, SdoAbort::kLengthTooHigh);
  EXPECT_EQ(error.expected, 3U);
  EXPECT_EQ(error.received, 7U);
  EXPECT_EQ(port.sent.back(), "601#8003200012000706");
  port.answer("581#410320000A000000");
  port.answer("581#0101020304050607");
  error = upload_error();
  EXPECT_EQ(error.code, SdoAbort::kLengthTooLow);
  EXPECT_EQ(error.expected, 10U);
  EXPECT_EQ(port.sent.back(), "601#6000000000000000") << "the node has finished: there is nothing to abort";
}

TEST_F(SdoClientTest, TwoGibibytesAreNotBegun) {
  port.answer("581#4103200000000080");
  const auto error = upload_error();
  EXPECT_EQ(error.code, SdoAbort::kOutOfMemory);
  EXPECT_EQ(error.received, 0x8000'0000U);
  EXPECT_THAT(port.sent, ElementsAre("601#4003200000000000", "601#8003200005000405"));
}

TEST_F(SdoClientTest, MoreThanAllowedWithoutASizeIsEnded) {
  client.set_options({.max_bytes = 10});
  port.answer("581#4003200000000000");
  port.answer("581#0001020304050607");
  port.answer("581#1001020304050607");
  EXPECT_EQ(upload_error().code, SdoAbort::kOutOfMemory);
}

TEST_F(SdoClientTest, SegmentsWithoutDataDoNotGoOnForEver) {
  port.answer("581#4003200000000000");
  port.answer("581#0E00000000000000");
  EXPECT_EQ(upload_error().code, SdoAbort::kGeneralError);
}

TEST_F(SdoClientTest, AnotherCommandThanASegmentEndsTheTransfer) {
  port.answer("581#4103200064000000");
  port.answer("581#2000000000000000");
  EXPECT_EQ(upload_error().code, SdoAbort::kInvalidCommand);
  EXPECT_EQ(port.sent.back(), "601#8003200001000405");
}

TEST_F(SdoClientTest, AnswersOfOthersAreIgnored) {
  std::vector<std::string> seen;
  link.set_listener([&](const ReceivedFrame& frame) { seen.push_back(std::to_string(frame.frame.identifier.value)); });
  port.answers({{1ms, "582#4300100001010101"},       // another node
                {1ms, "00000581#4300100001010101"},  // an extended identifier
                {2ms, "581#4300110001010101"},       // another object
                {2ms, "581#4300100101010101"},       // another sub-index
                {2ms, "581#8000110001010101"},       // abort of another transfer
                {2ms, "581#6000100000000000"},       // of a download
                {2ms, "581#43001000010101"},         // seven bytes
                {2ms, "701#05"},
                {3ms, "581#4300100092010200"}});
  EXPECT_EQ(*must(client.upload({0x1000, 0})), hex("92 01 02 00"));
  EXPECT_EQ(seen.size(), 9U) << "the listener sees them all";
}

TEST_F(SdoClientTest, NoAnswerEndsWithAnAbort) {
  port.answers({{1ms, "581#6003200000000000"}});
  const auto error = upload_error();
  EXPECT_EQ(error.kind, ClientErrorKind::kNoAnswer);
  EXPECT_EQ(error.waited, 500ms);
  EXPECT_EQ(error.ignored, 1U);
  EXPECT_EQ(describe(error),
            "node 1 did not answer within 500 ms, when asked for object 0x2003:00; 1 of its answers "
            "belong to no request of this program");
  EXPECT_THAT(port.sent, ElementsAre("601#4003200000000000", "601#8003200000000405"));
}

// c-open #42: the time-out is that of an answer, not of the transfer.
TEST_F(SdoClientTest, EachAnswerHasItsOwnTime) {
  port.answers({{450ms, "581#410320000E000000"}});
  port.answers({{450ms, "581#0001020304050607"}});
  port.answers({{450ms, "581#1108090A0B0C0D0E"}});
  EXPECT_EQ(must(client.upload({0x2003, 0}))->size(), 14U);
}

TEST_F(SdoClientTest, AnAnswerToAnAbandonedTransferIsNotTaken) {
  port.answers({{700ms, "581#6060600000000000"}});
  port.silence();  // an abort has no answer
  ASSERT_FALSE(client.download_number({0x6060, 0}, 7, 1));
  port.answer("581#8060600030000906");
  // The old confirmation comes 200 ms after the time-out. It is not that of this value, which the node refuses.
  const auto done = client.download_number({0x6060, 0}, 99, 1);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, SdoAbort::kValueRange);
  EXPECT_EQ(port.sent_at.back(), 1s + 700ms);
}

TEST_F(SdoClientTest, ASilentNodeIsAskedAgainAfterTheTimeOfItsOldAnswer) {
  ASSERT_FALSE(client.upload({0x1000, 0}));
  port.answer("581#4300100092010200");
  EXPECT_TRUE(client.upload({0x1000, 0}));
  EXPECT_EQ(port.sent_at.back(), 1s + 500ms + 500ms);
}

TEST_F(SdoClientTest, WhatArrivedBeforeTheRequestIsNoAnswer) {
  port.arrives(clock.now(), "581#4300100001010101");
  clock.advance(1ms);
  port.answer("581#4300100092010200");
  EXPECT_EQ(*must(client.upload({0x1000, 0})), hex("92 01 02 00"));
}

TEST_F(SdoClientTest, AnAdapterThatTakesNothingOrIsGone) {
  port.status = SendStatus::kBusy;
  auto error = upload_error();
  EXPECT_EQ(error.kind, ClientErrorKind::kBusy);
  EXPECT_EQ(error.node, 1);
  EXPECT_EQ(error.waited, 500ms);
  port.status = SendStatus::kDown;
  EXPECT_EQ(upload_error().kind, ClientErrorKind::kDown);
}

TEST_F(SdoClientTest, StoppingEndsTheTransferWithAnAbort) {
  const auto begin = clock.now();
  link.set_stop([&] { return clock.now() > begin + 100ms; });
  EXPECT_EQ(upload_error().kind, ClientErrorKind::kStopped);
  EXPECT_LT(clock.now(), begin + 200ms);
  EXPECT_THAT(port.sent, ElementsAre("601#4003200000000000", "601#8003200000000008"));
}

/// Whatever the node answers, a transfer ends, and within the time of its answers.
TEST_F(SdoClientTest, AnyAnswersEndTheTransfer) {
  std::uint32_t state = 2026;
  const auto random = [&] { return (state = state * 1664525U + 1013904223U) >> 24U; };
  for (int run = 0; run < 3000; ++run) {
    rt::VirtualClock own_clock{1s};
    ScriptedPort own_port(own_clock);
    BusLink own_link(own_port, own_clock);
    SdoOptions options;
    options.block = run % 3 == 0;
    options.max_bytes = 200;
    SdoClient own_client(own_link, 1, options);
    for (int i = 0; i < 200; ++i) {
      std::string frame = "581#";
      const auto first =
          random() % 4 == 0
              ? random()
              : std::array{0x41U, 0x60U, 0x00U, 0x10U, 0x20U, 0xA4U, 0xA2U, 0xC6U, 0x01U, 0x81U}.at(random() % 10);
      candump::Line text;
      text.add_hex(first, 2).add("032000");
      for (int byte = 0; byte < 4; ++byte) text.add_hex(random() % 5, 2);
      own_port.answer(frame + std::string(text.view()));
    }
    if (run % 2 == 0) {
      static_cast<void>(own_client.upload({0x2003, 0}));
    } else {
      static_cast<void>(own_client.download({0x2003, 0}, hex("0102030405060708090A0B0C0D0E0F101112")));
    }
    ASSERT_LT(own_clock.now(), 60s) << run;
    ASSERT_LT(own_port.sent.size(), 200U) << run;
  }
}

}  // namespace
}  // namespace driveline::canopen
