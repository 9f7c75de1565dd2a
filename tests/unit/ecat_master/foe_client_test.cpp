#include "driveline/ecat_master/foe/foe_client.hpp"

#include <gmock/gmock.h>

#include <array>

#include "support/mail_bench.hpp"

namespace driveline::ecat_master {
namespace {

using bytes_test::hex;
using ecat_master_test::MailBench;
using ecat_master_test::ScriptedMailbox;
using std::chrono::milliseconds;
using testing::ElementsAre;
using Bytes = std::vector<std::byte>;

/// A FoE client for a slave whose mailboxes have room for four bytes of data. Messages are plain bytes from ETG.1000.6
/// 5.8.
struct FileBench : MailBench {
  static constexpr std::uint16_t kMailbox = 16;
  FileBench() : MailBench(wire::MailboxType::kFoe, kMailbox, kMailbox) {}

  std::string read(const FileSettings& settings = {}) {
    const auto file = foe.read({"F", 0x12345678}, settings);
    return file ? "" : describe(file.error());
  }
  std::string write(std::string_view content, const FileSettings& settings = {}) {
    const auto bytes = std::as_bytes(std::span(content));
    const auto done = foe.write({"F", 0x12345678}, {bytes.begin(), bytes.end()}, settings);
    return done ? "" : describe(done.error());
  }

  /// The result of a transfer that a slave answers without end; empty: it was still open after five minutes.
  std::string outcome(FileTransfer& transfer) {
    const auto end = slave.now() + std::chrono::minutes{5};
    while (!transfer.done() && slave.now() < end) mailbox.engine().drive();
    if (!transfer.done()) return "";
    const auto result = result_of(transfer);
    return result ? "success" : describe(result.error());
  }

  FoeClient foe{mailbox};
};

TEST(FoeClient, ReadsAFileInPacketsAndAcknowledgesEach) {
  FileBench bench;
  bench.answer({"0300 01000000 61626364", "0300 02000000 65"});
  const auto file = bench.foe.read({"F", 0x12345678});
  ASSERT_TRUE(file);
  EXPECT_EQ(*file, hex("6162636465"));
  EXPECT_THAT(bench.told(), ElementsAre(hex("0100 78563412 46"), hex("0400 01000000"), hex("0400 02000000")));
}

TEST(FoeClient, WritesAFileInPackets) {
  FileBench bench;
  bench.answer({"0400 00000000", "0400 01000000", "0400 02000000"});
  EXPECT_EQ(bench.write("abcde"), "");
  EXPECT_THAT(bench.told(),
              ElementsAre(hex("0200 78563412 46"), hex("0300 01000000 61626364"), hex("0300 02000000 65")));
}

TEST(FoeClient, AnExactMultipleEndsWithAnEmptyPacketBothWays) {
  FileBench bench;
  bench.answer({"0400 00000000", "0400 01000000", "0400 02000000"});
  EXPECT_EQ(bench.write("abcd"), "");
  EXPECT_EQ(bench.told().back(), hex("0300 02000000"));
  FileBench back;
  back.answer({"0300 01000000 61626364", "0300 02000000"});
  EXPECT_EQ(back.read(), "");
  EXPECT_EQ(back.told().back(), hex("0400 02000000"));
}

TEST(FoeClient, AnEmptyFileIsOneEmptyPacket) {
  FileBench bench;
  bench.answer({"0400 00000000", "0400 01000000"});
  EXPECT_EQ(bench.write(""), "");
  EXPECT_EQ(bench.told().back(), hex("0300 01000000"));
}

TEST(FoeClient, LeavesABusySlaveAloneForLongerAndLongerAndRepeatsTheMail) {
  FileBench bench;
  bench.answer({"0600 0000 6400", "0400 00000000", "0600 3200 6400 77616974", "0600 6300 6400", "0400 01000000"});
  const auto begin = bench.slave.now();
  EXPECT_EQ(bench.write("a", {.first_pause = milliseconds{10}, .longest_pause = milliseconds{15}}), "");
  const auto request = hex("0200 78563412 46");
  const auto data = hex("0300 01000000 61");
  EXPECT_THAT(bench.told(), ElementsAre(request, request, data, data, data));
  EXPECT_GE(bench.slave.now() - begin, milliseconds{10 + 10 + 15});
  EXPECT_LT(bench.slave.now() - begin, milliseconds{10 + 10 + 15 + 10});
}

TEST(FoeClient, TakesTheAnswerThatABusySlaveSendsByItself) {
  FileBench bench;
  bench.slave.answers.push_back({bench.mail("0600 0000 0000"), bench.mail("0400 00000000")});
  bench.answer({"0400 01000000"});
  EXPECT_EQ(bench.write("a"), "");
  EXPECT_EQ(bench.told().size(), 2U) << "nothing was repeated";
}

TEST(FoeClient, GivesUpOnASlaveThatStaysBusyAndTellsIt) {
  FileBench bench;
  bench.answer({"0600 0000 0000", "0600 0000 0000", "0600 0000 0000", "0600 0000 0000"});
  EXPECT_EQ(bench.write("a", {.first_pause = milliseconds{10}, .busy_limit = milliseconds{50}}),
            "slave 3: was busy with the file for 30 ms without progress");
  EXPECT_EQ(bench.told().back(), hex("0500 00800000"));
}

TEST(FoeClient, NamesTheErrorOfTheSlaveAndItsWords) {
  FileBench bench;
  bench.answer({"0500 01800000", "0500 03800000 66756C6C", "0500 EFBEADDE 780079"});
  EXPECT_EQ(bench.read(), "slave 3: refused the file with FoE error 0x8001 (not found)");
  EXPECT_EQ(bench.write("abc"), "slave 3: refused the file with FoE error 0x8003 (disk full): full");
  EXPECT_EQ(bench.read(), "slave 3: refused the file with FoE error 0xDEADBEEF (unknown FoE error): x");
}

TEST(FoeClient, AnErrorEndsATransferThatIsUnderWay) {
  FileBench bench;
  bench.answer({"0400 00000000", "0500 0C800000"});
  EXPECT_EQ(bench.write("abcde"), "slave 3: refused the file with FoE error 0x800C (checksum wrong)");
}

TEST(FoeClient, AnswersAWrongPacketNumberWithItsError) {
  FileBench bench;
  bench.answer({"0300 01000000 61626364", "0300 03000000 65"});
  EXPECT_EQ(bench.read(), "slave 3: packet 2 of the file was expected, 3 came");
  EXPECT_EQ(bench.told().back(), hex("0500 05800000"));
  FileBench other;
  other.answer({"0400 00000000", "0400 01000100"});
  EXPECT_EQ(other.write("abcde"), "slave 3: packet 1 of the file was expected, 65537 came");
  EXPECT_EQ(other.told().back(), hex("0500 05800000"));
}

TEST(FoeClient, PassesOverWhatComesTwiceAndWhatIsLate) {
  FileBench bench;
  // The end of the previous transfer; an acknowledge of the previous packet.
  bench.slave.answers.push_back({bench.mail("0400 09000000"), bench.mail("0400 00000000")});
  bench.slave.answers.push_back({bench.mail("0400 00000000"), bench.mail("0400 01000000")});
  EXPECT_EQ(bench.write("abc"), "");
  FileBench back;
  back.slave.answers.push_back({back.mail("0300 05000000 61"), back.mail("0300 01000000 61626364")});
  back.slave.answers.push_back({back.mail("0300 01000000 61626364"), back.mail("0300 02000000")});
  EXPECT_EQ(back.read(), "");
}

TEST(FoeClient, TakesNoMoreOfAFileThanItIsTold) {
  FileBench bench;
  bench.answer({"0300 01000000 61626364", "0300 02000000 61626364"});
  EXPECT_EQ(bench.read({.largest = 7}), "slave 3: sends more than the 7 bytes of the file that are accepted");
  EXPECT_EQ(bench.told().back(), hex("0500 03800000"));
}

TEST(FoeClient, ASlaveThatAnswersWithoutEndDoesNotKeepATransferOpen) {
  const std::string malformed = "slave 3: sent a malformed mailbox";
  struct Hostile {
    const char* service;
    std::string read;
    std::string write;
  };
  const Hostile cases[] = {
      {"0600 0000 0000", "slave 3: was busy with the file for 75 ms without progress",
       "slave 3: was busy with the file for 75 ms without progress"},
      {"0600", malformed, malformed},
      {"0400 0000", malformed, malformed},
      {"", malformed, malformed},
      // Acknowledgement or data of a packet that was not sent; both are answers to a transfer before.
      {"0400 07000000", malformed, malformed},
      {"0300 07000000 61626364", malformed, malformed},
      // Requests, and reserved op codes.
      {"0100 00000000 46", malformed, malformed},
      {"0200 00000000 46", malformed, malformed},
      {"0000 00000000", malformed, malformed},
      {"0700 00000000", malformed, malformed},
  };
  const FileSettings settings{.timeout = milliseconds{30},
                              .first_pause = milliseconds{5},
                              .longest_pause = milliseconds{40},
                              .busy_limit = milliseconds{100}};
  for (const auto& [service, read, write] : cases) {
    FileBench bench;
    bench.slave.endless = [&bench, one = service] { return bench.mail(one); };
    EXPECT_EQ(bench.outcome(*bench.foe.start_read({"F", 0}, settings)), read) << service;
    FileBench other;
    other.slave.endless = [&other, one = service] { return other.mail(one); };
    EXPECT_EQ(other.outcome(*other.foe.start_write({"F", 0}, hex("616263646566"), settings)), write) << service;
  }
}

TEST(FoeClient, RepetitionsInTheMiddleOfAFileDoNotKeepItOpen) {
  const FileSettings settings{.timeout = milliseconds{30}};
  FileBench bench;
  bench.answer({"0300 01000000 61626364"});
  bench.slave.endless = [&bench] { return bench.mail("0300 01000000 61626364"); };
  EXPECT_EQ(bench.outcome(*bench.foe.start_read({"F", 0}, settings)), "slave 3: sent a malformed mailbox");
  FileBench other;
  other.answer({"0400 00000000"});
  other.slave.endless = [&other] { return other.mail("0400 00000000"); };
  EXPECT_EQ(other.outcome(*other.foe.start_write({"F", 0}, hex("616263646566"), settings)),
            "slave 3: sent a malformed mailbox");
}

TEST(FoeClient, DataWithoutEndStopAtTheLimit) {
  constexpr std::size_t kLimit = 4097;
  constexpr std::size_t kPerPacket = 4;
  FileBench bench;
  // The slave answers the n-th request with packet n.
  bench.slave.endless = [&bench] {
    const auto packet = bench.slave.requests.size();
    std::array<char, 24> text{};
    std::snprintf(text.data(), text.size(), "0300%02zX%02zX000061626364", packet & 0xFFU, packet >> 8U & 0xFFU);
    return bench.mail(text.data());
  };
  const auto transfer = bench.foe.start_read({"F", 0}, {.largest = kLimit});
  EXPECT_EQ(bench.outcome(*transfer), "slave 3: sends more than the 4097 bytes of the file that are accepted");
  EXPECT_EQ(transfer->transferred(), kLimit / kPerPacket * kPerPacket);
  EXPECT_EQ(bench.told().back(), hex("0500 03800000"));
}

TEST(FoeClient, TheTextOfAnErrorNeedsNoZeroAtItsEnd) {
  FileBench bench;
  bench.answer({"0500 01800000 61626364", "0500 01800000 61006364", "0500 01800000 00626364"});
  const std::string refused = "slave 3: refused the file with FoE error 0x8001 (not found)";
  EXPECT_EQ(bench.read(), refused + ": abcd") << "up to the last byte of the mailbox";
  EXPECT_EQ(bench.read(), refused + ": a");
  EXPECT_EQ(bench.read(), refused);
}

TEST(FoeClient, SilenceEndsInATimeoutAndAnErrorToTheSlave) {
  FileBench bench;
  bench.answer({"0400 00000000", ""});
  const auto begin = bench.slave.now();
  EXPECT_EQ(bench.write("abc", {.timeout = milliseconds{300}}), "slave 3: no mailbox reply within 300 ms");
  EXPECT_LT(bench.slave.now() - begin, milliseconds{500});
  EXPECT_EQ(bench.told().back(), hex("0500 00800000"));
}

TEST(FoeClient, ASlaveThatKnowsNoFoeIsSaidToDoSo) {
  FileBench bench;
  bench.slave.answers.push_back({hex("0400 0000 00 10 0100 0200")});
  EXPECT_EQ(bench.read(), "slave 3: answered with mailbox error 0x0002 (unsupported protocol)");
}

TEST(FoeClient, MailsThatAreCutAreNamed) {
  FileBench bench;
  bench.answer({"0400 0000"});
  EXPECT_EQ(bench.write("abc", {.timeout = milliseconds{300}}), "slave 3: sent a malformed mailbox");
}

TEST(FoeClient, ANameThatDoesNotFitIsRefused) {
  FileBench bench;
  const auto done = bench.foe.read({"longer", 0});
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().error.is<facts::ProcessDataSize>());
  EXPECT_TRUE(bench.slave.requests.empty());
}

TEST(FoeClient, MailboxesWithoutRoomForDataAreRefused) {
  for (const auto size : std::array<std::uint16_t, 4>{0, 6, 11, 12}) {
    ScriptedMailbox slave(size);
    Bus bus(slave);
    MailboxClient mailbox(bus, {3, 0x1004}, {ScriptedMailbox::kOut, size, ScriptedMailbox::kIn, size});
    EXPECT_FALSE(FoeClient(mailbox).read({"", 0})) << size;
    EXPECT_FALSE(FoeClient(mailbox).write({"", 0}, Bytes(1))) << size;
  }
}

}  // namespace
}  // namespace driveline::ecat_master
