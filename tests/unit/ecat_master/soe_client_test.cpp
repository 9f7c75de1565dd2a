#include "driveline/ecat_master/soe/soe_client.hpp"

#include <gmock/gmock.h>

#include <array>
#include <string>

#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/soe/soe_log.hpp"
#include "support/mail_bench.hpp"
#include "support/must.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::MailBench;
using ecat_master_test::ScriptedMailbox;
using facts::SoeDatum;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using wire::SoeElement;
using Bytes = std::vector<std::byte>;

constexpr SoeDatum kList{0, {17}};
constexpr SoeDatum kCommand{0, {99}};

/// A SoE client for a slave whose mailboxes have room for eight bytes after the SoE header. Messages are plain bytes
/// from ETG.1000.6 5.9.
struct SoeBench : MailBench {
  static constexpr std::uint16_t kMailbox = 18;
  SoeBench() : MailBench(wire::MailboxType::kSoe, kMailbox, kMailbox) {}

  std::string read(SoeDatum at = kList, wire::SoeElementSet elements = SoeElement::kValue) {
    const auto reading = soe.read(at, elements);
    return reading ? "" : describe(reading.error());
  }
  std::string write(const Bytes& data) {
    const auto done = soe.write(kList, SoeElement::kValue, data);
    return done ? "" : describe(done.error());
  }
  /// The result of a transfer that a slave answers without end; empty: it was still open after a minute.
  std::string outcome(SoeTransfer& transfer) {
    const auto end = slave.now() + std::chrono::minutes{1};
    while (!transfer.done() && slave.now() < end) mailbox.engine().drive();
    if (!transfer.done()) return "";
    return transfer.result() ? "success" : describe(transfer.result().error());
  }
  std::string execute(const SoeCommandSettings& settings = {}) {
    const auto done = soe.execute(kCommand, settings);
    return done ? "" : describe(done.error());
  }

  SoeClient soe{mailbox};
};

TEST(SoeClient, ReadsAnElement) {
  SoeBench bench;
  bench.answer_next({"6240 2880 0102"});
  const auto reading = must(bench.soe.read({3, {0x8028}}, SoeElement::kValue));
  EXPECT_EQ(reading->data, hex("0102"));
  EXPECT_THAT(bench.told(), ElementsAre(hex("6140 2880")));
}

TEST(SoeClient, ReadsSeveralElementsInFragments) {
  SoeBench bench;
  bench.answer_next({"0A46 0200 0400040056656C6F", "0A46 0100 0100110006000600", "0246 1100 0123456789AB"});
  const auto reading = must(bench.soe.read(kList, SoeElement::kName | SoeElement::kAttribute | SoeElement::kValue));
  EXPECT_EQ(reading->data, hex("0400040056656C6F 01001100 06000600 0123456789AB"));
  EXPECT_THAT(bench.told(), ElementsAre(hex("0146 1100")));
}

TEST(SoeClient, TakesTheCountOfASlaveThatCountsTheFragmentItSends) {
  SoeBench bench;
  bench.answer_next({"0A40 0300 01", "0A40 0200 02", "0240 1100 03"});
  EXPECT_EQ(bench.read(), "");
}

TEST(SoeClient, AFragmentCountThatDoesNotFitEndsTheTransfer) {
  const std::pair<std::vector<std::string_view>, const char*> cases[] = {
      {{"0A40 0300 01", "0A40 0100 02"},
       "slave 3: 2 further fragments of S-0-0017 of drive 0 were expected, 1 are announced"},
      {{"0A40 0300 01", "0A40 0300 02"},
       "slave 3: 2 further fragments of S-0-0017 of drive 0 were expected, 3 are announced"},
      {{"0A40 0000 01"}, "slave 3: 1 further fragments of S-0-0017 of drive 0 were expected, 0 are announced"},
      {{"0A40 0300 01", "0240 1100 02"},
       "slave 3: 2 further fragments of S-0-0017 of drive 0 were expected, 0 are announced"},
  };
  for (const auto& [mails, sentence] : cases) {
    SoeBench bench;
    bench.answer_next(mails);
    EXPECT_EQ(bench.read(), sentence);
  }
}

TEST(SoeClient, AnAnswerAboutAnotherDatumOrDriveEndsTheTransfer) {
  SoeBench bench;
  bench.answer({"0240 1200 01", "2240 1100 01"});
  EXPECT_EQ(bench.read(), "slave 3: request for S-0-0017 of drive 0 was answered with S-0-0018 of drive 0");
  EXPECT_EQ(bench.read(), "slave 3: request for S-0-0017 of drive 0 was answered with S-0-0017 of drive 1");
  bench.answer_next({"2A40 0100 01", "0240 1100 01"});
  EXPECT_THAT(bench.read(), HasSubstr("answered with S-0-0017 of drive 1"));
}

TEST(SoeClient, NamesEveryErrorOfTheSlave) {
  for (const auto& row : wire::kSoeErrorTexts) {
    SoeBench bench;
    const auto code = static_cast<unsigned>(row.code);
    char service[20];
    std::snprintf(service, sizeof service, "1240 1100 %02X%02X", code & 0xFFU, code >> 8);
    bench.answer_next({service});
    char number[8];
    std::snprintf(number, sizeof number, "%04X", code);
    EXPECT_EQ(bench.read(), "slave 3: refused S-0-0017 of drive 0 with SoE error 0x" + std::string(number) + " (" +
                                std::string(row.text) + ")");
  }
  SoeBench bench;
  bench.answer_next({"1440 1100 EFBE"});
  EXPECT_EQ(bench.write(hex("00")), "slave 3: refused S-0-0017 of drive 0 with SoE error 0xBEEF (unknown SoE error)");
}

TEST(SoeClient, WritesInOneMailWhatFits) {
  SoeBench bench;
  bench.answer_next({"0440 1100"});
  EXPECT_EQ(bench.write(hex("0102030405060708")), "");
  EXPECT_THAT(bench.told(), ElementsAre(hex("0340 1100 0102030405060708")));
}

TEST(SoeClient, WritesTheRestInFragmentsThatAreAnsweredOnce) {
  // One byte less than twice the room, twice the room, one more.
  const std::pair<std::size_t, std::size_t> cases[] = {{15, 2}, {16, 2}, {17, 3}};
  for (const auto& [size, mails] : cases) {
    SoeBench bench;
    for (std::size_t i = 1; i < mails; ++i) bench.slave.answers.emplace_back();
    bench.answer_next({"0440 1100"});
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::byte>(i);
    EXPECT_EQ(bench.write(data), "") << size;
    const auto told = bench.told();
    ASSERT_EQ(told.size(), mails) << size;
    Bytes arrived;
    for (std::size_t i = 0; i < mails; ++i) {
      const bool last = i + 1 == mails;
      EXPECT_EQ(Bytes(told[i].begin(), told[i].begin() + 2), hex(last ? "0340" : "0B40"));
      EXPECT_EQ(std::to_integer<std::size_t>(told[i][2]), last ? 0x11 : mails - 1 - i) << "fragments to come, or IDN";
      arrived.insert(arrived.end(), told[i].begin() + 4, told[i].end());
    }
    EXPECT_EQ(arrived, data);
  }
}

TEST(SoeClient, NothingOfSoeComesBetweenTheFragmentsOfAWrite) {
  SoeBench bench;
  bench.slave.answers.resize(2);
  bench.answer({"0440 1100", "0240 1200 01"});
  const auto write = bench.soe.start_write(kList, SoeElement::kValue, Bytes(20));
  const auto read = bench.soe.start_read({0, {18}}, SoeElement::kValue);
  bench.mailbox.engine().wait(*read);
  ASSERT_TRUE(write->done());
  EXPECT_TRUE(write->result());
  EXPECT_TRUE(read->result());
  EXPECT_EQ(bench.told().size(), 4U);
  EXPECT_EQ(bench.told().back(), hex("0140 1200"));
}

TEST(SoeClient, ASlaveMayConfirmEachFragment) {
  SoeBench bench;
  bench.answer({"0C40 0100", "0440 1100"});
  EXPECT_EQ(bench.write(Bytes(12)), "");
}

TEST(SoeClient, ARefusedWriteCanBeRepeated) {
  SoeBench bench;
  bench.answer({"1440 1100 0570", "0440 1100"});
  EXPECT_THAT(bench.write(hex("01")), HasSubstr("0x7005"));
  EXPECT_EQ(bench.write(hex("01")), "");
}

TEST(SoeClient, AWriteToASlaveThatTakesNoMailFailsAndSendsNothingLate) {
  SoeBench bench;
  bench.slave.busy = 1'000'000;
  EXPECT_THAT(bench.write(Bytes(20)), HasSubstr("no mailbox reply"));
  bench.slave.busy = 0;
  bench.answer_next({"0240 1100 01"});
  EXPECT_EQ(bench.read(), "");
  EXPECT_THAT(bench.told(), ElementsAre(hex("0140 1100"))) << "nothing is left of the write";
}

TEST(SoeClient, AWriteWithoutMailboxFails) {
  SoeBench bench;
  bench.mailbox.engine().close(3);
  EXPECT_EQ(bench.write(Bytes(20)), "slave 3: has no SoE mailbox");
}

TEST(SoeClient, WhatIsCutOrOddIsNamed) {
  const std::string malformed = "slave 3: sent a malformed mailbox";
  SoeBench bench;
  bench.answer({"1240 1100 01", "0241 1100 01", "0240"});
  EXPECT_EQ(bench.read(), malformed) << "half an error code";
  EXPECT_EQ(bench.read(), malformed) << "an element that nobody has asked for";
  EXPECT_EQ(bench.read(), malformed) << "no header, and no answer to the requests that are sent again";
}

TEST(SoeClient, AnswersOfTheWrongKindWithoutEndEndInTheTimeout) {
  // Read request, write request, write response, notification, emergency and the reserved op codes 0 and 7.
  for (const auto* service : {"0140 1100 01", "0340 1100 01", "0440 1100", "0501 1100 0300",
                              "0600 0000 30810A0102030405", "0040 1100 01", "0740 1100 01"}) {
    SoeBench bench;
    MailboxWindow window{ScriptedMailbox::kOut, SoeBench::kMailbox, ScriptedMailbox::kIn, SoeBench::kMailbox};
    window.timeouts.response = milliseconds{40};
    bench.mailbox.engine().open({3, 0x1004}, window);
    bench.slave.endless = [&bench, service] { return bench.mail(service); };
    EXPECT_EQ(bench.outcome(*bench.soe.start_read(kList, SoeElement::kValue)), "slave 3: no mailbox reply within 40 ms")
        << service;
  }
}

TEST(SoeClient, AWriteThatIsConfirmedWithoutEndEnds) {
  for (const std::size_t size : {8U, 20U}) {
    SoeBench bench;
    bench.slave.endless = [&bench] { return bench.mail("0C40 0100"); };
    EXPECT_EQ(bench.outcome(*bench.soe.start_write(kList, SoeElement::kValue, Bytes(size))),
              "slave 3: 0 further fragments of S-0-0017 of drive 0 were expected, 1 are announced")
        << size;
  }
}

/// A fragment that announces `left` more, from a slave that counts down.
std::string fragment(unsigned left, std::string_view data) {
  std::array<char, 10> head{};
  std::snprintf(head.data(), head.size(), "0A40%02X%02X", left & 0xFFU, left >> 8U & 0xFFU);
  return head.data() + std::string(data);
}

TEST(SoeClient, FragmentsWithoutDataEndTheTransfer) {
  SoeBench bench;
  unsigned left = 0xFFFF;
  bench.slave.endless = [&] { return bench.mail(fragment(left--, "")); };
  EXPECT_EQ(bench.outcome(*bench.soe.start_read(kList, SoeElement::kValue)), "slave 3: sent a malformed mailbox");
  EXPECT_GT(left, 0xFFF0U) << "at the first one";
}

TEST(SoeClient, TakesNoMoreFragmentsThanAllElementsHave) {
  constexpr unsigned kPerFragment = 8;
  static_assert(SoeTransfer::kLargest / kPerFragment < 0xFFFE, "the limit is met before the count has come to its end");
  SoeBench bench;
  unsigned left = 0xFFFF;
  bench.slave.endless = [&] { return bench.mail(fragment(left--, "0102030405060708")); };
  EXPECT_EQ(bench.outcome(*bench.soe.start_read(kList, SoeElement::kValue)), "slave 3: sent a malformed mailbox");
  EXPECT_GE(0xFFFF - left, SoeTransfer::kLargest / kPerFragment);
}

TEST(SoeClient, LengthWordsThatLieAreNamed) {
  // The attribute says a list of two-byte elements; each value contradicts its own length word.
  const std::pair<const char*, unsigned> cases[] = {
      {"0240 1100 FFFFFFFF 01001180", 8},  // more than comes
      {"0240 1100 02000800 01001180", 8},  // less than comes
      {"0240 1100 00000000 0100", 6},      // none, and data
      {"0240 1100 040000", 3},             // less than the length words
      {"0240 1100", 0},                    // nothing
  };
  for (const auto& [value, bytes] : cases) {
    SoeBench bench;
    bench.answer({"0204 1100 0100 5500", value});
    EXPECT_EQ(describe(bench.soe.idn_list(kList).error()), "slave 3: the " + std::to_string(bytes) +
                                                               " bytes of S-0-0017 of drive 0 do not match its "
                                                               "attribute")
        << value;
  }
  SoeBench bench;
  bench.answer_next({"0202 1100 FF00FF00 41"});
  EXPECT_TRUE(bench.soe.name(kList).error().is<facts::SoeContent>()) << "a name";
  bench.answer_next({"0200 1100"});
  EXPECT_TRUE(bench.soe.attribute(kList).error().is<facts::SoeContent>()) << "without the element";
}

TEST(SoeClient, ASlaveThatKnowsNoSoeIsSaidToDoSo) {
  SoeBench bench;
  bench.slave.answers.push_back({hex("0400 0000 00 10 0100 0200")});
  EXPECT_EQ(bench.read(), "slave 3: answered with mailbox error 0x0002 (unsupported protocol)");
}

TEST(SoeClient, PassesOverWhatIsNoAnswer) {
  SoeBench bench;
  SoeLog log;
  bench.mailbox.engine().handle(wire::MailboxType::kSoe, log);
  bench.slave.answers.push_back({bench.mail("0501 6300 0300"), bench.mail("0440 1100"), bench.mail("0240 1100 01")});
  EXPECT_EQ(bench.read(), "");
  EXPECT_THAT(log.take(), testing::SizeIs(1));
}

TEST(SoeClient, AnSdoAndAnOperationDatumDoNotMixUp) {
  SoeBench bench;
  CoeClient coe(bench.mailbox);
  bench.slave.answers.push_back({bench.mail("0030 4F00100004000000", wire::MailboxType::kCoe)});
  bench.answer_next({"0240 1100 2A"});
  const auto sdo = coe.start_upload({0x1000, 0}, {}, 3);
  const auto datum = bench.soe.start_read(kList, SoeElement::kValue);
  bench.mailbox.engine().wait(*datum);
  EXPECT_EQ(sdo.get().value(), hex("04"));
  EXPECT_EQ(datum->result()->data, hex("2A"));
}

TEST(SoeClient, TheValueHasTheLengthOfItsAttribute) {
  SoeBench bench;
  bench.answer({"0204 1100 0100 2200", "0240 1100 01020304"});
  EXPECT_EQ(bench.soe.value(kList).value(), hex("01020304"));
  bench.answer({"0204 1100 0100 2200", "0240 1100 0102"});
  EXPECT_EQ(describe(bench.soe.value(kList).error()),
            "slave 3: the 2 bytes of S-0-0017 of drive 0 do not match its attribute");
}

TEST(SoeClient, ListsAreReadAndWrittenBehindTheirHeader) {
  SoeBench bench;
  bench.answer({"0204 1100 0100 5500", "0240 1100 04000800 01001180"});
  EXPECT_THAT(bench.soe.idn_list(kList).value(), ElementsAre(wire::Idn{1}, wire::Idn{0x8011}));
  bench.answer({"0204 1100 0100 5500", "0440 1100"});
  EXPECT_TRUE(bench.soe.write_value(kList, hex("01001180")));
  EXPECT_EQ(bench.told().back(), hex("0340 1100 04000400 01001180"));
  bench.answer({"0204 1100 0100 5500", "0240 1100 05000800 010011"});
  EXPECT_TRUE(bench.soe.value(kList).error().is<facts::SoeContent>()) << "more is promised than comes";
  bench.answer({"0204 1100 0100 5500", "0240 1100 03000800 010011"});
  EXPECT_TRUE(bench.soe.idn_list(kList).error().is<facts::SoeContent>()) << "half an IDN";
}

TEST(SoeClient, TellsEverythingAboutADatumButWhatTheSlaveRefuses) {
  SoeBench bench;
  bench.answer({"0204 1100 0100 1100", "1201 1100 1470", "0202 1100 0300030054656D", "1208 1100 0140", "0210 1100 0100",
                "0220 1100 0900", "0240 1100 0500", "1280 1100 0180"});
  // The name announces three bytes and has three.
  const auto parameter = must(bench.soe.parameter(kList));
  EXPECT_EQ(parameter->name, "Tem");
  EXPECT_FALSE(parameter->state);
  EXPECT_FALSE(parameter->unit);
  EXPECT_EQ(parameter->min, hex("0100"));
  EXPECT_EQ(parameter->max, hex("0900"));
  EXPECT_EQ(parameter->value, hex("0500"));
  EXPECT_FALSE(parameter->preset);
}

TEST(SoeCommand, IsSetAwaitedAndCancelled) {
  SoeBench bench;
  bench.answer({"0440 6300", "0201 6300 0700", "0201 6300 0300", "0440 6300"});
  EXPECT_EQ(bench.execute(), "");
  EXPECT_THAT(bench.told(),
              ElementsAre(hex("0340 6300 0300"), hex("0101 6300"), hex("0101 6300"), hex("0340 6300 0000")));
}

TEST(SoeCommand, ThatFailsIsNamedAndCancelled) {
  SoeBench bench;
  bench.answer({"0440 6300", "0201 6300 0F00", "0440 6300"});
  EXPECT_EQ(bench.execute(), "slave 3: the procedure command S-0-0099 of drive 0 ended in data state 0x000F (failed)");
  EXPECT_EQ(bench.told().back(), hex("0340 6300 0000"));
}

TEST(SoeCommand, ThatIsNotOverInTimeIsCancelled) {
  SoeBench bench;
  for (const auto* mail : {"0440 6300", "0201 6300 0700", "0201 6300 0700", "0440 6300"}) bench.answer_next({mail});
  EXPECT_EQ(bench.execute({.limit = milliseconds{15}, .interval = milliseconds{10}}),
            "slave 3: the procedure command S-0-0099 of drive 0 did not end within 15 ms");
  EXPECT_EQ(bench.told().back(), hex("0340 6300 0000"));
}

TEST(SoeCommand, ThatTheSlaveRefusesIsNotCancelled) {
  SoeBench bench;
  bench.answer_next({"1440 6300 1070"});
  EXPECT_EQ(bench.execute(),
            "slave 3: refused S-0-0099 of drive 0 with SoE error 0x7010 (the command is active already)");
  EXPECT_EQ(bench.told().size(), 1U) << "it may be another master's";
}

TEST(SoeLog, KeepsNotificationsAndEmergenciesInWords) {
  SoeLog log;
  log.receive({4, 0x1005}, hex("0501 6300 0300"), milliseconds{3201});
  log.receive({4, 0x1005}, hex("4600 0000 30810A0102030405"), milliseconds{3202});
  for (const auto* other : {"0240 1100 01", "0501 6300 03", "4600 0000 30", "05"}) {
    log.receive({4, 0x1005}, hex(other), milliseconds{3203});
  }
  const auto records = log.take();
  ASSERT_EQ(records.size(), 2U);
  EXPECT_EQ(describe(records[0]), "3.201 s slave 4 drive 0: data state of S-0-0099 is 0x0003 (executed)");
  EXPECT_EQ(describe(records[1]), "3.202 s slave 4 drive 2: emergency 0x8130, error register 0x0A, 01 02 03 04 05");
  EXPECT_TRUE(log.take().empty());
}

TEST(SoeLog, TellsRequestsOfADriveFromMessages) {
  const SoeLog log;
  for (const auto* request : {"0140 1100", "0340 1100 05"}) EXPECT_TRUE(log.is_request(hex(request))) << request;
  for (const auto* other : {"0240 1100 01", "0440 1100", "0501 6300 0300", "4600 0000 30810A0102030405", "01"}) {
    EXPECT_FALSE(log.is_request(hex(other))) << other;
  }
}

TEST(SoeLog, DropsTheOldestAndCountsIt) {
  SoeLog log;
  for (std::size_t i = 0; i <= SoeLog::kMaxRecords; ++i) {
    log.receive({static_cast<std::uint16_t>(i), 0}, hex("0501 6300 0300"), {});
  }
  EXPECT_EQ(log.dropped(), 1U);
  EXPECT_EQ(log.take().front().slave, 1U);
}

}  // namespace
}  // namespace driveline::ecat_master
