#include "driveline/ecat_master/coe/coe_client.hpp"

#include <gmock/gmock.h>

#include "driveline/ecat_master/coe/emergency_log.hpp"
#include "driveline/ecat_master/configuration/pdo_mapping.hpp"
#include "support/mail_bench.hpp"
#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::facts_of;
using ecat_master_test::MailBench;
using testing::ElementsAre;
using Bytes = std::vector<std::byte>;

/// A CoE client for a slave with mailboxes of `out` and `in` bytes.
struct Bench : MailBench {
  explicit Bench(std::uint16_t out = 1024, std::uint16_t in = 1024) : MailBench(wire::MailboxType::kCoe, out, in) {
    mailbox.engine().handle(wire::MailboxType::kCoe, emergencies);
  }
  /// Service data of the n-th request.
  [[nodiscard]] Bytes service(std::size_t n) const { return told().at(n); }

  EmergencyLog emergencies;
  CoeClient coe{mailbox};
};

TEST(CoeAgainstACapture, ReadsTheAssignmentAsAnotherMasterDid) {
  // Public capture of a master that scans a Kollmorgen AKD: mailboxes as they went over the wire, counters included.
  const std::pair<std::string_view, std::string_view> dialogue[] = {
      {"0a0000000013 002040001c0000000000", "0a0000000013 00304f001c0004000000"},
      {"0a0000000023 002040001c0300000000", "0a0000000023 00304f001c0303000000"},
      {"0a0000000033 002040121c0000000000", "0a0000000033 00304f121c0004000000"},
      {"0a0000000043 002040121c0100000000", "0a0000000043 00304b121c0100160000"},
      {"0a0000000053 00204000160000000000", "0a0000000053 00304f00160001000000"},
      {"0a0000000063 00204000160100000000", "0a0000000063 00304300160110004060"},
      {"0a0000000073 002040121c0200000000", "0a0000000073 00304b121c0201160000"},
      {"0a0000000013 00204001160000000000", "0a0000000013 00304f01160002000000"},
      {"0a0000000023 00204001160100000000", "0a0000000023 00304301160110004060"},
      {"0a0000000033 00204001160200000000", "0a0000000033 00304301160208006060"},
      {"0a0000000043 002040121c0300000000", "0a0000000043 00304b121c0302160000"},
      {"0a0000000053 00204002160000000000", "0a0000000053 00304f02160002000000"},
      {"0a0000000063 00204002160100000000", "0a0000000063 00304302160110004060"},
      {"0a0000000073 00204002160200000000", "0a0000000073 00304302160220007a60"},
      {"0a0000000013 002040121c0400000000", "0a0000000013 00304b121c0403160000"},
      {"0a0000000023 00204003160000000000", "0a0000000023 00304f03160002000000"},
      {"0a0000000033 00204003160100000000", "0a0000000033 00304303160110004060"},
      {"0a0000000043 00204003160200000000", "0a0000000043 0030430316022000ff60"},
  };
  Bench bench;
  for (const auto& [request, answer] : dialogue) bench.slave.answers.push_back({hex(answer)});
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x1C00, 0).value(), 4);
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x1C00, 3).value(), 3);
  const auto bytes = must(read_assigned_bytes(bench.coe, 0x1C12));
  // 16; 16 + 8; 16 + 32; 16 + 32 bits.
  EXPECT_EQ(*bytes, 17U);
  ASSERT_EQ(bench.slave.requests.size(), std::size(dialogue));
  for (std::size_t i = 0; i < std::size(dialogue); ++i) EXPECT_EQ(bench.slave.requests[i], hex(dialogue[i].first)) << i;
}

// Formats below: CiA 301 7.2.4.3, ETG.1000.6 5.6.2.

TEST(CoeUpload, ExpeditedOfOneToFourBytes) {
  Bench bench;
  bench.answer({"0030 4F 4160 00 11000000", "0030 4B 4160 00 11220000", "0030 47 4160 00 11223300",
                "0030 43 4160 00 11223344", "0030 42 4160 00 11223344"});
  for (const std::string_view data : {"11", "1122", "112233", "11223344", "11223344"}) {
    const auto read = must(bench.coe.upload(0x6041, 0));
    EXPECT_EQ(*read, hex(data));
  }
  EXPECT_EQ(bench.service(0), hex("0020 40 4160 00 00000000"));
}

TEST(CoeUpload, NormalInOneMailbox) {
  Bench bench;
  bench.answer({"0030 41 0810 00 05000000 48656C6C6F"});
  EXPECT_EQ(bench.coe.upload(0x1008, 0).value(), hex("48656C6C6F"));
  EXPECT_EQ(bench.slave.requests.size(), 1U);
}

TEST(CoeUpload, NormalWithPaddingBehindTheData) {
  Bench bench;
  bench.answer({"0030 41 0810 00 05000000 48656C6C6F 000000"});
  EXPECT_EQ(bench.coe.upload(0x1008, 0).value(), hex("48656C6C6F"));
}

TEST(CoeUpload, OfAnEmptyObject) {
  Bench bench;
  bench.answer({"0030 41 0810 00 00000000"});
  EXPECT_TRUE(bench.coe.upload(0x1008, 0).value().empty());
}

TEST(CoeUpload, InSegments) {
  Bench bench;
  // 20 bytes: 2 with the first answer, 7, 7 and 4 in segments.
  bench.answer(
      {"0030 41 0810 00 14000000 0001", "0030 00 02030405060708", "0030 10 090A0B0C0D0E0F", "0030 07 10111213 000000"});
  EXPECT_EQ(bench.coe.upload(0x1008, 0).value(), hex("000102030405060708090A0B0C0D0E0F10111213"));
  EXPECT_EQ(bench.service(1), hex("0020 60 00000000000000"));
  EXPECT_EQ(bench.service(2), hex("0020 70 00000000000000"));
  EXPECT_EQ(bench.service(3), hex("0020 60 00000000000000"));
}

TEST(CoeUpload, InSegmentsLongerThanSevenBytes) {
  Bench bench;
  bench.answer({"0030 41 0810 00 0A000000", "0030 01 00010203040506070809"});
  EXPECT_EQ(bench.coe.upload(0x1008, 0).value(), hex("00010203040506070809"));
}

TEST(CoeUpload, CompleteAccess) {
  Bench bench;
  bench.answer({"0030 51 1810 00 06000000 0400 11223344"});
  EXPECT_EQ(bench.coe.upload(0x1018, 0, true).value(), hex("040011223344"));
  EXPECT_EQ(bench.service(0), hex("0020 50 1810 00 00000000"));
}

TEST(CoeDownload, ExpeditedOfOneToFourBytes) {
  Bench bench;
  bench.answer(
      {"0030 60 6060 00 00000000", "0030 60 4060 00 00000000", "0030 60 0020 01 00000000", "0030 60 7A60 00 00000000"});
  EXPECT_TRUE(bench.coe.download(0x6060, 0, hex("08")));
  EXPECT_TRUE(bench.coe.download(0x6040, 0, hex("0F00")));
  EXPECT_TRUE(bench.coe.download(0x2000, 1, hex("112233")));
  EXPECT_TRUE(bench.coe.download_as<std::int32_t>(0x607A, 0, -2));
  EXPECT_EQ(bench.service(0), hex("0020 2F 6060 00 08000000"));
  EXPECT_EQ(bench.service(1), hex("0020 2B 4060 00 0F000000"));
  EXPECT_EQ(bench.service(2), hex("0020 27 0020 01 11223300"));
  EXPECT_EQ(bench.service(3), hex("0020 23 7A60 00 FEFFFFFF"));
}

TEST(CoeDownload, NormalInOneMailbox) {
  Bench bench;
  bench.answer({"0030 60 0320 00 00000000"});
  EXPECT_TRUE(bench.coe.download(0x2003, 0, hex("4142434445")));
  EXPECT_EQ(bench.service(0), hex("0020 21 0320 00 05000000 4142434445"));
}

TEST(CoeDownload, OfNothing) {
  Bench bench;
  bench.answer({"0030 60 0320 00 00000000"});
  EXPECT_TRUE(bench.coe.download(0x2003, 0, {}));
  EXPECT_EQ(bench.service(0), hex("0020 21 0320 00 00000000"));
}

TEST(CoeDownload, InSegments) {
  // A mailbox of 24 bytes: 6 header, 2 CoE, 8 SDO, 8 data; segments of 15 data bytes.
  Bench bench(24, 24);
  Bytes data;
  for (unsigned i = 0; i < 26; ++i) data.push_back(static_cast<std::byte>(i));
  bench.answer({"0030 60 0320 00 00000000", "0030 20 00000000000000", "0030 30 00000000000000"});
  ASSERT_TRUE(bench.coe.download(0x2003, 0, data));
  ASSERT_EQ(bench.slave.requests.size(), 3U);
  EXPECT_EQ(bench.service(0), hex("0020 21 0320 00 1A000000 0001020304050607"));
  EXPECT_EQ(bench.service(1), hex("0020 00 08090A0B0C0D0E0F10111213141516"));
  // Three bytes left, four of seven unused, last.
  EXPECT_EQ(bench.service(2), hex("0020 19 171819 00000000"));
}

TEST(CoeDownload, CompleteAccessIsNeverExpedited) {
  Bench bench;
  bench.answer({"0030 60 121C 00 00000000"});
  EXPECT_TRUE(bench.coe.download(0x1C12, 0, hex("0000"), true));
  EXPECT_EQ(bench.service(0), hex("0020 31 121C 00 02000000 0000"));
}

TEST(CoeErrors, AnAbortNamesItsObject) {
  Bench bench;
  bench.answer({"0030 80 4160 07 11000906"});
  const auto read = bench.coe.upload(0x6041, 7);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().slave, 3);
  const auto abort = facts_of<facts::SdoAbort>(read);
  EXPECT_EQ(abort.object, (facts::ObjectAddress{0x6041, 7}));
  EXPECT_EQ(abort.code, wire::SdoAbort::kSubindexDoesNotExist);
}

TEST(CoeErrors, AnAbortSentAsARequestIsOneToo) {
  Bench bench;
  bench.answer({"0020 80 4160 00 00000206"});
  EXPECT_EQ(facts_of<facts::SdoAbort>(bench.coe.upload(0x6041, 0)).code, wire::SdoAbort::kObjectDoesNotExist);
}

TEST(CoeErrors, AnAbortAmidSegmentsEndsTheTransfer) {
  Bench bench;
  bench.answer({"0030 41 0810 00 14000000", "0030 00 02030405060708", "0030 80 0810 00 00000008"});
  EXPECT_TRUE(bench.coe.upload(0x1008, 0).error().is<facts::SdoAbort>());
  EXPECT_EQ(bench.slave.requests.size(), 3U);
}

TEST(CoeErrors, AWrongToggleIsAborted) {
  Bench bench;
  bench.answer({"0030 41 0810 00 14000000", "0030 10 02030405060708"});
  EXPECT_TRUE(bench.coe.upload(0x1008, 0).error().is<facts::MailboxMalformed>());
  ASSERT_EQ(bench.slave.requests.size(), 3U);
  EXPECT_EQ(bench.service(2), hex("0020 80 0810 00 00000305")) << "0503 0000h: toggle bit not alternated";
}

TEST(CoeErrors, AWrongToggleOfADownloadIsAborted) {
  Bench bench(24, 24);
  bench.answer({"0030 60 0320 00 00000000", "0030 30 00000000000000"});
  EXPECT_TRUE(bench.coe.download(0x2003, 0, Bytes(40)).error().is<facts::MailboxMalformed>());
  EXPECT_EQ(bench.service(2), hex("0020 80 0320 00 00000305"));
}

TEST(CoeErrors, MoreSegmentDataThanAnnouncedIsAborted) {
  Bench bench;
  bench.answer({"0030 41 0810 00 0A000000", "0030 00 02030405060708", "0030 11 02030405060708"});
  const auto wrong = facts_of<facts::SdoSize>(bench.coe.upload(0x1008, 0));
  EXPECT_EQ(wrong.expected, 10U);
  EXPECT_EQ(wrong.received, 14U);
  EXPECT_EQ(bench.service(3), hex("0020 80 0810 00 10000706")) << "0607 0010h: length mismatch";
}

TEST(CoeErrors, LessSegmentDataThanAnnouncedIsAnError) {
  Bench bench;
  bench.answer({"0030 41 0810 00 0A000000", "0030 01 02030405060708"});
  EXPECT_EQ(facts_of<facts::SdoSize>(bench.coe.upload(0x1008, 0)).received, 7U);
}

TEST(CoeErrors, SegmentsWithoutDataDoNotGoOnForever) {
  Bench bench;
  bench.answer({"0030 41 0810 00 0A000000", "0030 0E 00000000000000", "0030 1E 00000000000000"});
  EXPECT_TRUE(bench.coe.upload(0x1008, 0).error().is<facts::SdoSize>());
  EXPECT_EQ(bench.slave.requests.size(), 3U) << "initiate, one segment, abort";
}

TEST(CoeErrors, AnObjectLargerThanAllowedIsAbortedAtOnce) {
  Bench bench;
  bench.answer({"0030 41 0810 00 FFFFFFFF 00"});
  EXPECT_EQ(facts_of<facts::SdoSize>(bench.coe.upload(0x1008, 0)).received, 0xFFFFFFFFU);
  EXPECT_EQ(bench.service(1), hex("0020 80 0810 00 05000405")) << "0504 0005h: out of memory";
}

TEST(CoeErrors, AnAnswerAboutAnotherObjectIsMalformed) {
  for (const std::string_view answer :
       {"0030 4F 4260 00 11000000", "0030 4F 4160 01 11000000", "0030 60 4160 00 00000000", "0030 4F 4160"}) {
    Bench bench;
    bench.answer({answer});
    EXPECT_EQ(facts_of<facts::MailboxMalformed>(bench.coe.upload(0x6041, 0)).object.index, 0x6041) << answer;
  }
}

TEST(CoeErrors, AHeaderThatIsLongerThanTheMailboxIsMalformed) {
  Bench bench(64, 64);
  auto mail = bench.mail("0030 4F 4160 00 11000000");
  mail[0] = std::byte{59};
  bench.slave.answers.push_back({mail});
  EXPECT_TRUE(bench.coe.upload(0x6041, 0).error().is<facts::MailboxMalformed>());
}

TEST(CoeErrors, AValueOfAnotherSizeIsNamed) {
  Bench bench;
  bench.answer({"0030 4B 4160 00 11220000"});
  const auto wrong = facts_of<facts::SdoSize>(bench.coe.upload_as<std::uint32_t>(0x6041, 0));
  EXPECT_EQ(wrong.expected, 4U);
  EXPECT_EQ(wrong.received, 2U);
}

TEST(CoeErrors, SilenceEndsInATimeout) {
  Bench bench;
  EXPECT_EQ(facts_of<facts::MailboxTimeout>(bench.coe.upload(0x6041, 2)).object, (facts::ObjectAddress{0x6041, 2}));
  EXPECT_GE(bench.slave.now(), MailboxClient::kReplyTimeout);
  EXPECT_LT(bench.slave.now(), 2 * MailboxClient::kReplyTimeout);
}

TEST(MailboxClient, AMailboxErrorReplyCarriesItsDetail) {
  Bench bench;
  bench.slave.answers.push_back({bench.mail("0100 0200", wire::MailboxType::kError)});
  EXPECT_EQ(facts_of<facts::MailboxError>(bench.coe.upload(0x6041, 0)).code, 2U);
}

TEST(MailboxClient, CollectsEmergenciesAheadOfTheAnswer) {
  Bench bench;
  bench.slave.answers.push_back({bench.mail("0010 2032 05 0501000000"), bench.mail("0010 0000 00 0000000000"),
                                 bench.mail("0030 4F 4160 00 11000000")});
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 0).value(), 0x11);
  const auto emergencies = bench.emergencies.take(3);
  ASSERT_EQ(emergencies.size(), 2U);
  EXPECT_EQ(emergencies[0].message.error_code, 0x3220);
  EXPECT_EQ(emergencies[0].message.error_register, 5);
  EXPECT_EQ(emergencies[0].message.data[0], std::byte{5});
  EXPECT_EQ(emergencies[1].message.error_code, 0);
  EXPECT_TRUE(bench.emergencies.take(3).empty());
}

TEST(MailboxClient, KeepsTheNewestEmergencies) {
  Bench bench;
  std::vector<Bytes> mails;
  for (unsigned i = 0; i < EmergencyLog::kMaxPerSlave + 3; ++i) {
    mails.push_back(bench.mail("0010 0000 00 0000000000"));
    mails.back()[8] = static_cast<std::byte>(i);
  }
  mails.push_back(bench.mail("0030 4F 4160 00 11000000"));
  bench.slave.answers.push_back(mails);
  ASSERT_TRUE(bench.coe.upload(0x6041, 0));
  const auto emergencies = bench.emergencies.take(3);
  ASSERT_EQ(emergencies.size(), EmergencyLog::kMaxPerSlave);
  EXPECT_EQ(emergencies.front().message.error_code, 3);
  EXPECT_EQ(emergencies.back().message.error_code, EmergencyLog::kMaxPerSlave + 2);
}

TEST(MailboxClient, SkipsWhatBelongsToOtherProtocols) {
  Bench bench;
  bench.slave.answers.push_back({bench.mail("00000000", wire::MailboxType::kEoe), bench.mail("0080 02000000"),
                                 bench.mail(""), bench.mail("0030 4F 4160 00 11000000")});
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 0).value(), 0x11);
}

TEST(MailboxClient, SkipsAMailboxThatComesTwice) {
  Bench bench;
  const auto first = bench.mail("0030 4F 4160 00 11000000");
  bench.slave.answers.push_back({first});
  bench.slave.answers.push_back({first, bench.mail("0030 4F 4160 00 22000000")});
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 0).value(), 0x11);
  EXPECT_EQ(bench.coe.upload_as<std::uint8_t>(0x6041, 0).value(), 0x22);
}

TEST(MailboxClient, TakesUncountedMailboxesAsNew) {
  Bench bench;
  for (int i = 0; i < 2; ++i) {
    auto mail = bench.mail("0030 4F 4160 00 11000000");
    mail[5] = std::byte{3};
    bench.slave.answers.push_back({mail});
  }
  EXPECT_TRUE(bench.coe.upload(0x6041, 0));
  EXPECT_TRUE(bench.coe.upload(0x6041, 0));
}

TEST(MailboxClient, IsNotHeldUpByASlaveThatOnlyChatters) {
  Bench bench;
  bench.slave.endless = [&] { return bench.mail("0010 2032 05 0501000000"); };
  EXPECT_TRUE(bench.coe.upload(0x6041, 0).error().is<facts::MailboxTimeout>());
}

TEST(MailboxClient, IsNotHeldUpByASlaveThatRepeatsItself) {
  Bench bench;
  const auto same = bench.mail("0010 2032 05 0501000000");
  bench.slave.endless = [&same] { return std::vector(same); };
  EXPECT_TRUE(bench.coe.upload(0x6041, 0).error().is<facts::MailboxTimeout>());
  EXPECT_EQ(bench.emergencies.take(3).size(), 1U) << "said once, however often it is repeated";
}

TEST(MailboxClient, WaitsForAFullMailboxToBeTaken) {
  Bench bench;
  bench.slave.busy = 20;
  bench.answer({"0030 4F 4160 00 11000000"});
  EXPECT_TRUE(bench.coe.upload(0x6041, 0));
  EXPECT_EQ(bench.slave.requests.size(), 1U);
}

TEST(MailboxClient, GivesUpOnAMailboxThatStaysFull) {
  Bench bench;
  bench.slave.busy = 1'000'000;
  EXPECT_TRUE(bench.coe.upload(0x6041, 0).error().is<facts::MailboxTimeout>());
}

TEST(MailboxClient, RefusesAServiceThatDoesNotFit) {
  Bench bench(16, 16);
  const auto done = bench.mailbox.send(wire::MailboxType::kCoe, Bytes(11));
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::ProcessDataSize>());
  EXPECT_TRUE(bench.slave.requests.empty());
}

TEST(MailboxClient, SurvivesMailboxesOfAbsurdSizes) {
  for (const auto size : std::array<std::uint16_t, 6>{0, 1, 5, 6, 7, 9}) {
    Bench bench(size, size);
    EXPECT_FALSE(bench.coe.upload(0x6041, 0)) << size;
    EXPECT_FALSE(bench.coe.download(0x2003, 0, Bytes(40))) << size;
  }
}

TEST(PdoConfiguration, IsWrittenInTheOrderOfTheStandard) {
  Bench bench;
  motion::PdoConfiguration pdos;
  pdos.outputs = {{0x1600, {{0x6040, 0, 16}, {0x607A, 0, 32}}}};
  const std::string_view objects[] = {"121C 00", "0016 00", "0016 01", "0016 02", "0016 00", "121C 00",
                                      "121C 01", "121C 00", "131C 00", "131C 00", "131C 00"};
  std::vector<std::string> answers;
  for (const auto object : objects) answers.push_back("0030 60 " + std::string(object) + " 00000000");
  for (const auto& answer : answers) bench.answer({answer});
  ASSERT_TRUE(write_pdo_configuration(bench.coe, pdos));
  std::vector<Bytes> services;
  for (std::size_t i = 0; i < bench.slave.requests.size(); ++i) services.push_back(bench.service(i));
  EXPECT_THAT(
      services,
      ElementsAre(hex("0020 2F 121C 00 00000000"), hex("0020 2F 0016 00 00000000"), hex("0020 23 0016 01 10004060"),
                  hex("0020 23 0016 02 20007A60"), hex("0020 2F 0016 00 02000000"), hex("0020 2F 121C 00 00000000"),
                  hex("0020 2B 121C 01 00160000"), hex("0020 2F 121C 00 01000000"), hex("0020 2F 131C 00 00000000"),
                  hex("0020 2F 131C 00 00000000"), hex("0020 2F 131C 00 00000000")));
}

}  // namespace
}  // namespace driveline::ecat_master
