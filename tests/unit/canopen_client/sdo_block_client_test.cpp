#include "driveline/canopen_client/sdo_client.hpp"
#include "scripted_port.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

/// Block transfers with node 1 (CiA 301 7.2.4.3.8 to .15). The data are "123456789", whose CRC is 31C3h in the
/// catalogues of CRC algorithms (CRC-16/XMODEM).
class SdoBlockClientTest : public ScriptedBus {
 protected:
  SdoBlockClientTest() { client.set_options({.block = true}); }
  SdoClient client{link, 1};
  std::vector<std::byte> digits = hex("31 32 33 34 35 36 37 38 39");

  void begin_upload() {
    port.answer("581#C603200009000000");
    port.answers({{1ms, "581#0131323334353637"}, {2ms, "581#8238390000000000"}});
  }
};

TEST_F(SdoBlockClientTest, Uploads) {
  begin_upload();
  port.answer("581#D5C3310000000000");
  EXPECT_EQ(*must(client.upload({0x2003, 0})), digits);
  EXPECT_THAT(port.sent, ElementsAre("601#A40320007F000000", "601#A300000000000000", "601#A2027F0000000000",
                                     "601#A100000000000000"));
}

TEST_F(SdoBlockClientTest, AWrongCrcEndsTheUpload) {
  begin_upload();
  port.answer("581#D5C4310000000000");
  EXPECT_EQ(client.upload({0x2003, 0}).error().code, SdoAbort::kCrcError);
  EXPECT_EQ(port.sent.back(), "601#8003200004000405");
}

TEST_F(SdoBlockClientTest, ALostSegmentOfAnUploadComesAgain) {
  port.answer("581#C603200009000000");
  port.answers({{2ms, "581#8238390000000000"}});
  port.answers({{1ms, "581#0131323334353637"}, {2ms, "581#8238390000000000"}});
  port.answer("581#D5C3310000000000");
  EXPECT_EQ(*must(client.upload({0x2003, 0})), digits);
  EXPECT_EQ(port.sent[2], "601#A2007F0000000000") << "none is confirmed";
  EXPECT_EQ(port.sent[3], "601#A2027F0000000000");
}

TEST_F(SdoBlockClientTest, ALostLastSegmentIsAskedForAfterTheTimeOut) {
  port.answer("581#C603200009000000");
  port.answers({{1ms, "581#0131323334353637"}});
  port.answer("581#8138390000000000");
  port.answer("581#D5C3310000000000");
  EXPECT_EQ(*must(client.upload({0x2003, 0})), digits);
  EXPECT_EQ(port.sent[2], "601#A2017F0000000000");
}

TEST_F(SdoBlockClientTest, ANodeThatSendsNoSegmentIsGivenUp) {
  port.answer("581#C603200009000000");
  const auto data = client.upload({0x2003, 0});
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().kind, ClientErrorKind::kNoAnswer);
  EXPECT_EQ(port.sent.size(), 1U + 4U + 1U) << "initiate, the start and three repetitions, abort";
}

TEST_F(SdoBlockClientTest, SizesThatLieAreRefused) {
  port.answer("581#C603200000000080");
  EXPECT_EQ(client.upload({0x2003, 0}).error().code, SdoAbort::kOutOfMemory);
  port.answer("581#C603200008000000");
  port.answers({{1ms, "581#0131323334353637"}, {2ms, "581#8238390000000000"}});
  port.answer("581#D5C3310000000000");
  EXPECT_EQ(client.upload({0x2003, 0}).error().code, SdoAbort::kLengthTooHigh);
  port.answer("581#C603200001000000");
  port.answers({{1ms, "581#0131323334353637"}, {2ms, "581#0238390000000000"}});
  EXPECT_EQ(client.upload({0x2003, 0}).error().code, SdoAbort::kLengthTooHigh);
}

TEST_F(SdoBlockClientTest, ASequenceNumberOutOfRangeEndsTheUpload) {
  client.set_options({.block = true, .block_segments = 4});
  port.answer("581#C603200009000000");
  port.answer("581#0531323334353637");
  EXPECT_EQ(client.upload({0x2003, 0}).error().code, SdoAbort::kInvalidSequenceNumber);
}

TEST_F(SdoBlockClientTest, AnAbortAmongTheSegments) {
  port.answer("581#C603200009000000");
  port.answers({{1ms, "581#0131323334353637"}, {2ms, "581#8003200020000008"}});
  const auto data = client.upload({0x2003, 0});
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().code, SdoAbort::kCannotTransferOrStore);
  EXPECT_EQ(port.sent.size(), 2U);
}

TEST_F(SdoBlockClientTest, Downloads) {
  port.answer("581#A40320007F000000");
  port.silence();
  port.answer("581#A2027F0000000000");
  port.answer("581#A100000000000000");
  EXPECT_TRUE(client.download({0x2003, 0}, digits));
  EXPECT_THAT(port.sent, ElementsAre("601#C603200009000000", "601#0131323334353637", "601#8238390000000000",
                                     "601#D5C3310000000000"));
}

// CANopenNode #170: the transfer goes on behind the last segment that has arrived.
TEST_F(SdoBlockClientTest, ALostSegmentOfADownloadIsSentAgain) {
  port.answer("581#A003200001000000");
  port.answer("581#A201020000000000");
  port.answer("581#A200010000000000");  // it has not arrived
  port.answer("581#A201010000000000");
  port.answer("581#A100000000000000");
  EXPECT_TRUE(client.download({0x2003, 0}, digits));
  EXPECT_THAT(port.sent, ElementsAre("601#C603200009000000", "601#0131323334353637", "601#8138390000000000",
                                     "601#8138390000000000", "601#D500000000000000"))
      << "without a CRC, which the node has not";
}

TEST_F(SdoBlockClientTest, ANodeThatTakesNoSegmentIsGivenUp) {
  port.answer("581#A003200001000000");
  for (int i = 0; i < 4; ++i) port.answer("581#A200010000000000");
  const auto done = client.download({0x2003, 0}, digits);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ClientErrorKind::kNoAnswer);
  EXPECT_EQ(port.sent.size(), 1U + 4U + 1U);
}

TEST_F(SdoBlockClientTest, WrongConfirmationsEndTheDownload) {
  port.answer("581#A403200000000000");
  EXPECT_EQ(client.download({0x2003, 0}, digits).error().code, SdoAbort::kInvalidBlockSize);
  port.answer("581#A403200080000000");
  EXPECT_EQ(client.download({0x2003, 0}, digits).error().code, SdoAbort::kInvalidBlockSize);
  port.answer("581#A40320007F000000");
  port.silence();
  port.answer("581#A2037F0000000000");
  EXPECT_EQ(client.download({0x2003, 0}, digits).error().code, SdoAbort::kInvalidSequenceNumber);
  EXPECT_EQ(port.sent.back(), "601#8003200003000405");
}

}  // namespace
}  // namespace driveline::canopen
