#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

// The trace in MSD manual 8.2.4: upload of a string of 100 bytes, byte for byte, with its pauses.
TEST_F(CanopenDevice, C28UploadsTheTraceOfTheManual) {
  struct Exchange {
    double second;
    const char* request;
    const char* answer;
  };
  const std::vector<Exchange> trace{{18.992445, "40 03 20 00 00 00 00 00", "41 03 20 00 64 00 00 00"},
                                    {35.514341, "60 00 00 00 00 00 00 00", "00 58 2D 41 78 69 73 00"},
                                    {36.269620, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {36.982385, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {37.686447, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {38.421344, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {39.053526, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {39.749081, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {40.428981, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {41.085839, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {41.740755, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {42.514034, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {43.172512, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {43.908571, "60 00 00 00 00 00 00 00", "00 00 00 00 00 00 00 00"},
                                    {44.668466, "70 00 00 00 00 00 00 00", "10 00 00 00 00 00 00 00"},
                                    {53.884044, "60 00 00 00 00 00 00 00", "0B 00 00 00 00 00 00 00"}};
  // Boot-up in time to be ready at the start of the trace, c-open #42: the pauses end nothing.
  for (const auto& exchange : trace) {
    rig.run(nanoseconds{static_cast<std::int64_t>(exchange.second * 1e9)} - rig.bus.now());
    EXPECT_EQ(rig.ask(exchange.request), hex(exchange.answer)) << exchange.second;
  }
}

// C28: expedited up and download, with and without size.
TEST_F(CanopenDevice, C28Expedited) {
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("4B 00 20 00 EF FF 00 00"));  // INTEGER16 -17
  EXPECT_EQ(rig.ask("2B 00 20 00 34 12 00 00"), hex("60 00 20 00 00 00 00 00"));
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_EQ(rig.ask("22 00 20 00 78 56 AA BB"),
            hex("60 00 20 00 00 00 00 00"));  // size not indicated: as many as needed
  EXPECT_EQ(rig.value(0x2000), 0x5678U);
  EXPECT_EQ(rig.ask("23 02 20 00 78 56 34 12"), hex("60 02 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("40 02 20 00 00 00 00 00"), hex("43 02 20 00 78 56 34 12"));
  EXPECT_EQ(rig.ask("2F 01 20 00 C3 00 00 00"), hex("60 01 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("40 01 20 00 00 00 00 00"), hex("4F 01 20 00 C3 00 00 00"));
}

// MC7000 manual 4.3.2, 6.5.2.1: the size is not stated in answers, and four bytes are taken for entries of one or two.
TEST(CanopenSdo, SizesCountOnlyWhereTheDeviceLooksAtThem) {
  DeviceRig rig({.size_indicated = false, .cut_expedited = true});
  rig.run(2ms);
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("42 00 20 00 EF FF 00 00"));
  EXPECT_EQ(rig.ask("23 01 20 00 3C 12 34 56"), hex("60 01 20 00 00 00 00 00"));
  EXPECT_EQ(rig.value(0x2001), 0x3CU);
  EXPECT_EQ(rig.ask("2F 02 20 00 3C 00 00 00"), hex("80 02 20 00 13 00 07 06")) << "too short is too short";
}

TEST(CanopenSdo, UnusedBytesOfASignedValueHaveItsSignWhereTheDeviceDoesSo) {  // MSD manual 8.2.2
  DeviceRig rig({.fill_sign = true});
  rig.run(2ms);
  EXPECT_EQ(rig.ask("40 00 20 00 00 00 00 00"), hex("4B 00 20 00 EF FF FF FF"));
  EXPECT_EQ(rig.ask("40 01 20 00 00 00 00 00"), hex("4F 01 20 00 05 00 00 00"));
}

// C28: segmented download; rules of toggle, size and last segment.
TEST_F(CanopenDevice, C28SegmentedDownload) {
  EXPECT_EQ(rig.ask("21 03 20 00 09 00 00 00"), hex("60 03 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("00 59 2D 41 78 69 73 20"), hex("20 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("1B 34 32 00 00 00 00 00"), hex("30 00 00 00 00 00 00 00"));  // last, 5 unused
  EXPECT_EQ(rig.dictionary.text(rig.dictionary.table().find(0x2003, 0)->slot), "Y-Axis 42");
}

TEST_F(CanopenDevice, C28SegmentedDownloadWithoutSize) {
  EXPECT_EQ(rig.ask("20 04 20 00 00 00 00 00"), hex("60 04 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("00 01 02 03 04 05 06 07"), hex("20 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("1D 88 00 00 00 00 00 00"), hex("30 00 00 00 00 00 00 00"));
  EXPECT_EQ(rig.value(0x2004), 0x8807'0605'0403'0201U);
}

// C29 (canopen-stack #132): a new initiate ends an unfinished transfer and is answered for its own object.
TEST_F(CanopenDevice, C29ANewRequestGetsItsOwnData) {
  EXPECT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  EXPECT_EQ(rig.ask("40 01 20 00 00 00 00 00"), hex("4F 01 20 00 05 00 00 00"));
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("80 00 00 00 01 00 04 05"));  // the old transfer is over
  EXPECT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  EXPECT_EQ(rig.ask("2F 01 20 00 37 00 00 00"), hex("60 01 20 00 00 00 00 00"));
  EXPECT_EQ(rig.value(0x2001), 0x37U);
  EXPECT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  EXPECT_EQ(rig.ask("40 05 20 00 00 00 00 00"), hex("80 05 20 00 01 00 01 06"));  // an abort names the new object
  EXPECT_EQ(rig.ask("21 03 20 00 09 00 00 00"), hex("60 03 20 00 00 00 00 00"));
  EXPECT_EQ(rig.ask("40 08 10 00 00 00 00 00"), hex("41 08 10 00 0D 00 00 00"));
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("00 53 61 6D 70 6C 65 20"));
  EXPECT_EQ(rig.ask("70 00 00 00 00 00 00 00"), hex("13 64 65 76 69 63 65 00"));  // 13 = 7 + 6
}

// C30: an abort of the client ends the transfer and has no answer.
TEST_F(CanopenDevice, C30AbortHasNoAnswer) {
  ASSERT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  EXPECT_THAT(rig.ask("80 03 20 00 00 00 04 05"), IsEmpty());
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("80 00 00 00 01 00 04 05"));
}

// C32: fewer than 8 bytes: ignored and counted, and no end of a transfer.
TEST_F(CanopenDevice, C32ShortRequestsAreIgnored) {
  ASSERT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  EXPECT_THAT(rig.ask("40 00 10 00 00 00 00"), IsEmpty());
  EXPECT_THAT(rig.ask(""), IsEmpty());
  EXPECT_EQ(rig.device.ignored(), 2U);
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("00 58 2D 41 78 69 73 00"));
}

// C34: no answer in Stopped, which also ends a transfer.
TEST_F(CanopenDevice, C34NoAnswerInStopped) {
  ASSERT_EQ(rig.ask("40 03 20 00 00 00 00 00"), hex("41 03 20 00 64 00 00 00"));
  rig.nmt(canopen::NmtCommand::kStop);
  EXPECT_THAT(rig.ask("60 00 00 00 00 00 00 00"), IsEmpty());
  rig.start();
  EXPECT_EQ(rig.ask("60 00 00 00 00 00 00 00"), hex("80 00 00 00 01 00 04 05"));
}

TEST(CanopenSdo, AnswersLeaveAfterTheDelayOfTheDevice) {
  DeviceRig rig({.sdo_request = 0x610, .sdo_answer = 0x590, .sdo_delay = 500us});
  rig.run(2ms);
  const nanoseconds asked = rig.bus.now();
  rig.send(0x615, "40 00 10 00 00 00 00 00");
  ASSERT_EQ(rig.seen(0x595).size(), 1U);
  EXPECT_EQ(rig.payloads(0x595).front(), hex("43 00 10 00 92 01 02 00"));
  // Each of the two frames of 8 bytes takes at least 108 us until it is received.
  EXPECT_GT(rig.seen(0x595).front().time - asked, 500us + 216us);
  EXPECT_LT(rig.seen(0x595).front().time - asked, 500us + 264us);
}

TEST(CanopenSdo, MoreRequestsThanAnswersCanWaitAreCountedAndLost) {
  DeviceRig rig({.sdo_delay = 50ms});
  rig.run(2ms);
  for (int i = 0; i < 20; ++i) rig.send(0x605, "40 00 10 00 00 00 00 00");
  rig.run(100ms);
  EXPECT_EQ(rig.answers().size(), 16U);
}

}  // namespace
}  // namespace driveline::slaves::cia301
