#include "driveline/slaves/mailbox/soe_server.hpp"

#include <gmock/gmock.h>

#include <array>
#include <map>
#include <string>

#include "driveline/slaves/idn/idn_dictionary.hpp"

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::IsEmpty;
using wire::SoeError;
using Bytes = std::vector<unsigned>;

std::vector<std::byte> to_bytes(const Bytes& values) {
  std::vector<std::byte> bytes;
  for (const auto value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

constexpr Slot<std::uint16_t> kTime{0};
constexpr Slot<IdnList> kList{1};

const IdnTable& first_drive() {
  static const std::array kRows = {
      in_slot(kTime, {.idn = {1},
                      .name = "Time",
                      .attribute = {.op_protected = true},
                      .unit = "us",
                      .initial = 50,
                      .minimum = 10,
                      .maximum = 512,
                      .has_default = true}),
      IdnRow{.idn = {0x8002},
             .attribute = {.length_code = 0, .display = wire::SoeDisplay::kSigned},
             .minimum = -2,
             .maximum = 1},
      IdnRow{.idn = {17},
             .name = "All",
             .attribute = {.list = true,
                           .display = wire::SoeDisplay::kIdn,
                           .pre_op_protected = true,
                           .safe_op_protected = true,
                           .op_protected = true},
             .selection = IdnSelection::kAll},
      in_slot(kList, {.idn = {0x8003}, .name = "List", .attribute = {.length_code = 1, .list = true}, .capacity = 40}),
      IdnRow{.idn = {99}, .name = "Go", .attribute = {.command = true, .display = wire::SoeDisplay::kBinary}}};
  static const IdnTable kTable({kRows}, 2);
  return kTable;
}

const IdnTable& second_drive() {
  static const std::array kRows = {IdnRow{.idn = {1}, .name = "N", .initial = 7}};
  static const IdnTable kTable({kRows}, 0);
  return kTable;
}

/// Two drives with a number, a list and a procedure command.
class Table final : public IdnDictionary {
 public:
  Table() : IdnDictionary({&first_drive(), &second_drive()}) { values(0).set(kTime, std::uint16_t{100}); }
  int started = 0;
  std::optional<SoeError> refusal;

 private:
  SoeAnswer<void> start_command(std::uint8_t, wire::Idn) override {
    ++started;
    if (refusal) return tl::unexpected(*refusal);
    return {};
  }
};

/// A server behind mailboxes with room for eight bytes after the SoE header. Requests and answers are plain numbers
/// from ETG.1000.6 5.9, independent of the encoder under test.
struct SoeRig {
  static constexpr std::size_t kRoom = 12;
  Bytes ask(const Bytes& request, wire::AlState in = wire::AlState::kPreOp) {
    const auto data = to_bytes(request);
    std::vector<std::byte> out(kRoom, std::byte{0xEE});
    const auto length = server.request({data, kRoom, in}, out);
    if (!length) return {0xFFFF, static_cast<unsigned>(length.error())};
    return cut(out, *length);
  }
  Bytes more() {
    std::vector<std::byte> out(kRoom, std::byte{0xEE});
    return cut(out, server.unsolicited(out));
  }
  static Bytes cut(const std::vector<std::byte>& out, std::size_t length) {
    EXPECT_LE(length, kRoom);
    Bytes answer;
    for (std::size_t i = 0; i < length; ++i) answer.push_back(std::to_integer<unsigned>(out[i]));
    return answer;
  }
  /// Writes to P-0-0003 in fragments of 8 bytes; returns the answer to the last one.
  Bytes write_list(const Bytes& data, unsigned count_more = 0) {
    std::size_t at = 0;
    for (auto left = static_cast<unsigned>((data.size() - 1) / 8); left > 0; --left, at += 8) {
      Bytes part{0x0B, 0x40, left + count_more, 0};
      part.insert(part.end(), data.begin() + static_cast<std::ptrdiff_t>(at),
                  data.begin() + static_cast<std::ptrdiff_t>(at + 8));
      EXPECT_THAT(ask(part), IsEmpty());
    }
    Bytes last{0x03, 0x40, 0x03, 0x80};
    last.insert(last.end(), data.begin() + static_cast<std::ptrdiff_t>(at), data.end());
    return ask(last);
  }

  Table table;
  SoeServer server{table};
};

const Bytes kWritten{0x04, 0x40, 0x03, 0x80};

Bytes refused(unsigned first, unsigned elements, unsigned idn, unsigned code) {
  return {first | 0x10U, elements, idn & 0xFFU, idn >> 8, code & 0xFFU, code >> 8};
}

TEST(SoeServer, ReadsEachElement) {
  SoeRig rig;
  EXPECT_THAT(rig.ask({1, 0x40, 1, 0}), ElementsAre(2, 0x40, 1, 0, 100, 0));
  EXPECT_THAT(rig.ask({1, 0x02, 1, 0}), ElementsAre(2, 0x02, 1, 0, 4, 0, 4, 0, 'T', 'i', 'm', 'e'));
  EXPECT_THAT(rig.ask({1, 0x04, 1, 0}), ElementsAre(2, 0x04, 1, 0, 1, 0, 0x11, 0x40));
  EXPECT_THAT(rig.ask({1, 0x08, 1, 0}), ElementsAre(2, 0x08, 1, 0, 2, 0, 2, 0, 'u', 's'));
  EXPECT_THAT(rig.ask({1, 0x10, 1, 0}), ElementsAre(2, 0x10, 1, 0, 10, 0));
  EXPECT_THAT(rig.ask({1, 0x20, 1, 0}), ElementsAre(2, 0x20, 1, 0, 0, 2));
  EXPECT_THAT(rig.ask({1, 0x80, 1, 0}), ElementsAre(2, 0x80, 1, 0, 50, 0));
  EXPECT_THAT(rig.ask({1, 0x01, 99, 0}), ElementsAre(2, 0x01, 99, 0, 0, 0));
  EXPECT_THAT(rig.ask({0x21, 0x40, 1, 0}), ElementsAre(0x22, 0x40, 1, 0, 7, 0)) << "of the other drive";
}

TEST(SoeServer, SendsInFragmentsWhatDoesNotFit) {
  SoeRig rig;
  // Name, attribute, unit and value: 8 + 4 + 6 + 2 bytes.
  EXPECT_THAT(rig.ask({1, 0x4E, 1, 0}), ElementsAre(0x0A, 0x4E, 2, 0, 4, 0, 4, 0, 'T', 'i', 'm', 'e'));
  EXPECT_THAT(rig.more(), ElementsAre(0x0A, 0x4E, 1, 0, 1, 0, 0x11, 0x40, 2, 0, 2, 0));
  EXPECT_THAT(rig.more(), ElementsAre(0x02, 0x4E, 1, 0, 'u', 's', 100, 0));
  EXPECT_THAT(rig.more(), IsEmpty());
  // The list of all: 4 + 10 bytes.
  EXPECT_THAT(rig.ask({1, 0x40, 17, 0}), ElementsAre(0x0A, 0x40, 1, 0, 10, 0, 10, 0, 1, 0, 17, 0));
  EXPECT_THAT(rig.more(), ElementsAre(0x02, 0x40, 17, 0, 99, 0, 2, 0x80, 3, 0x80));
}

TEST(SoeServer, AnAnswerThatFillsItsMailsHasNoEmptyOne) {
  SoeRig rig;
  for (const std::size_t size : {7U, 8U, 9U, 15U, 16U, 17U}) {
    rig.table.values(0).set(kList, std::vector(size - 4, std::byte{0x5A}));
    auto answer = rig.ask({1, 0x40, 3, 0x80});
    std::size_t bytes = 0;
    std::size_t mails = 0;
    for (; !answer.empty(); answer = rig.more(), ++mails) {
      ASSERT_GT(answer.size(), 4U) << size;
      bytes += answer.size() - 4;
    }
    EXPECT_EQ(bytes, size);
    EXPECT_EQ(mails, (size + 7) / 8);
  }
}

TEST(SoeServer, TakesAWriteInOneMail) {
  SoeRig rig;
  EXPECT_THAT(rig.ask({3, 0x40, 1, 0, 0x2C, 0x01}), ElementsAre(4, 0x40, 1, 0));
  EXPECT_EQ(rig.table.values(0).get(kTime), 300);
}

TEST(SoeServer, TakesAWriteInFragmentsAsMastersCountThem) {
  for (const unsigned count_more : {0U, 1U}) {
    for (const unsigned size : {2U, 4U, 6U, 12U, 20U}) {
      SoeRig rig;
      Bytes data{size, 0, size, 0};
      for (unsigned i = 0; i < size; ++i) data.push_back(i);
      EXPECT_EQ(rig.write_list(data, count_more), kWritten) << size;
      EXPECT_THAT(rig.table.values(0).get(kList), ElementsAreArray(to_bytes(Bytes(data.begin() + 4, data.end()))));
    }
  }
}

TEST(SoeServer, AFragmentThatIsMissingOrForeignSpoilsTheWrite) {
  const auto general = refused(4, 0x40, 0x8003, 0x800B);
  const Bytes end{3, 0x40, 3, 0x80, 1};
  SoeRig rig;
  // A gap; a repeated fragment; a missing last fragment; another drive; other elements.
  const std::vector<std::vector<Bytes>> cases{{{0x0B, 0x40, 3, 0, 4, 0, 4, 0}, {0x0B, 0x40, 1, 0}},
                                              {{0x0B, 0x40, 3, 0, 4, 0, 4, 0}, {0x0B, 0x40, 3, 0}},
                                              {{0x0B, 0x40, 3, 0, 4, 0, 4, 0}},
                                              {{0x2B, 0x40, 1, 0, 4, 0, 4, 0}},
                                              {{0x0B, 0x10, 1, 0, 4, 0, 4, 0}}};
  for (const auto& fragments : cases) {
    for (const auto& fragment : fragments) EXPECT_THAT(rig.ask(fragment), IsEmpty());
    EXPECT_EQ(rig.ask(end), general);
  }
  EXPECT_TRUE(rig.table.values(0).get(kList).empty());
  EXPECT_EQ(rig.write_list({2, 0, 2, 0, 1, 2}), kWritten) << "and then it works";
}

TEST(SoeServer, AWriteWithoutEndIsCutAndRefusedWhenItEnds) {
  SoeRig rig;
  for (unsigned left = 20000; left > 0; --left) {
    EXPECT_THAT(rig.ask({0x0B, 0x40, left & 0xFFU, left >> 8, 1, 2, 3, 4, 5, 6, 7, 8}), IsEmpty());
  }
  EXPECT_EQ(rig.ask({3, 0x40, 3, 0x80, 1}), refused(4, 0x40, 0x8003, 0x7003));
}

TEST(SoeServer, AReadOrAStopForgetsAWriteThatHasBegun) {
  for (const bool stops : {false, true}) {
    SoeRig rig;
    EXPECT_THAT(rig.ask({0x0B, 0x40, 1, 0, 4, 0, 4, 0}), IsEmpty());
    if (stops) {
      rig.server.stop();
    } else {
      EXPECT_EQ(rig.ask({1, 0x40, 1, 0})[0], 2U);
    }
    EXPECT_EQ(rig.write_list({2, 0, 2, 0, 1, 2}), kWritten);
  }
  SoeRig rig;
  EXPECT_EQ(rig.ask({1, 0x4E, 1, 0})[0], 0x0AU);
  rig.server.stop();
  EXPECT_THAT(rig.more(), IsEmpty());
}

TEST(SoeServer, RefusesWithTheCodesOfTheStandard) {
  SoeRig rig;
  EXPECT_EQ(rig.ask({1, 0x40, 2, 0}), refused(2, 0x40, 2, 0x1001));
  EXPECT_EQ(rig.ask({3, 0x40, 2, 0, 1}), refused(4, 0x40, 2, 0x1001));
  EXPECT_EQ(rig.ask({0x41, 0x40, 1, 0}), refused(0x42, 0x40, 1, 0x800A));
  EXPECT_EQ(rig.ask({0x43, 0x40, 1, 0, 1, 0}), refused(0x44, 0x40, 1, 0x800A));
  EXPECT_EQ(rig.ask({1, 0, 1, 0}), refused(2, 0, 1, 0x800C));
  EXPECT_EQ(rig.ask({3, 0, 1, 0, 1, 0}), refused(4, 0, 1, 0x800C));
  EXPECT_EQ(rig.ask({3, 0x50, 1, 0, 1, 0}), refused(4, 0x50, 1, 0x800B)) << "one element at a time";
  // Missing elements.
  const std::pair<unsigned, unsigned> none[] = {{0x01, 0x7014}, {0x02, 0x2001}, {0x08, 0x4001}, {0x80, 0x8001}};
  for (const auto& [element, code] : none) {
    EXPECT_EQ(rig.ask({1, element, 2, 0x80}), refused(2, element, 0x8002, code));
  }
  EXPECT_EQ(rig.ask({1, 0x10, 99, 0}), refused(2, 0x10, 99, 0x5001));
  EXPECT_EQ(rig.ask({1, 0x20, 99, 0}), refused(2, 0x20, 99, 0x6001));
  // Elements that cannot be written.
  const std::pair<unsigned, unsigned> fixed[] = {{0x01, 0x1009}, {0x02, 0x2004}, {0x04, 0x3004}, {0x08, 0x4004},
                                                 {0x10, 0x5004}, {0x20, 0x6004}, {0x80, 0x8004}};
  for (const auto& [element, code] : fixed) {
    EXPECT_EQ(rig.ask({3, element, 1, 0, 1, 0}), refused(4, element, 1, code));
  }
  EXPECT_EQ(rig.ask({3, 0x40, 17, 0, 0, 0, 0, 0}), refused(4, 0x40, 17, 0x7004));
}

TEST(SoeServer, ChecksLengthLimitsAndState) {
  SoeRig rig;
  EXPECT_EQ(rig.ask({3, 0x40, 1, 0, 100}), refused(4, 0x40, 1, 0x7002));
  EXPECT_EQ(rig.ask({3, 0x40, 1, 0, 100, 0, 0}), refused(4, 0x40, 1, 0x7003));
  EXPECT_EQ(rig.ask({3, 0x40, 1, 0, 9, 0}), refused(4, 0x40, 1, 0x7006));
  EXPECT_EQ(rig.ask({3, 0x40, 1, 0, 1, 2}), refused(4, 0x40, 1, 0x7007));
  EXPECT_THAT(rig.ask({3, 0x40, 1, 0, 0, 2}), testing::SizeIs(4)) << "the maximum itself";
  EXPECT_THAT(rig.ask({3, 0x40, 1, 0, 10, 0}), testing::SizeIs(4)) << "the minimum itself";
  EXPECT_EQ(rig.ask({3, 0x40, 1, 0, 100, 0}, wire::AlState::kOp), refused(4, 0x40, 1, 0x7005));
  EXPECT_THAT(rig.ask({3, 0x40, 1, 0, 100, 0}, wire::AlState::kSafeOp), testing::SizeIs(4));
  // With a sign: -2 to 1.
  for (const unsigned good : {0xFEU, 0xFFU, 0U, 1U}) EXPECT_THAT(rig.ask({3, 0x40, 2, 0x80, good}), testing::SizeIs(4));
  EXPECT_EQ(rig.ask({3, 0x40, 2, 0x80, 0xFD}), refused(4, 0x40, 0x8002, 0x7006));
  EXPECT_EQ(rig.ask({3, 0x40, 2, 0x80, 2}), refused(4, 0x40, 0x8002, 0x7007));
  // Lists.
  EXPECT_EQ(rig.ask({3, 0x40, 3, 0x80, 2, 0, 2}), refused(4, 0x40, 0x8003, 0x7002));
  EXPECT_EQ(rig.ask({3, 0x40, 3, 0x80, 2, 0, 2, 0, 1}), refused(4, 0x40, 0x8003, 0x7002));
  EXPECT_EQ(rig.ask({3, 0x40, 3, 0x80, 2, 0, 2, 0, 1, 2, 3}), refused(4, 0x40, 0x8003, 0x7003));
  EXPECT_EQ(rig.ask({3, 0x40, 3, 0x80, 1, 0, 1, 0, 1}), refused(4, 0x40, 0x8003, 0x7008));
  Bytes longer{42, 0, 42, 0};
  longer.resize(46);
  EXPECT_EQ(rig.write_list(longer), refused(4, 0x40, 0x8003, 0x7003)) << "more than its capacity";
}

TEST(SoeServer, CommandsKeepTheirStateAndTellTheirEnd) {
  SoeRig rig;
  const Bytes state{1, 0x01, 99, 0};
  EXPECT_THAT(rig.ask({3, 0x40, 99, 0, 3, 0}), testing::SizeIs(4));
  EXPECT_THAT(rig.ask(state), ElementsAre(2, 0x01, 99, 0, 7, 0)) << "in progress";
  EXPECT_EQ(rig.ask({3, 0x40, 99, 0, 3, 0}), refused(4, 0x40, 99, 0x7010));
  EXPECT_THAT(rig.more(), IsEmpty());
  rig.table.end_command(0, {99}, wire::SoeCommandState::kExecuted);
  rig.table.end_command(0, {99}, wire::SoeCommandState::kFailed);
  EXPECT_THAT(rig.more(), ElementsAre(5, 0x01, 99, 0, 3, 0));
  EXPECT_THAT(rig.more(), IsEmpty()) << "it has ended once";
  EXPECT_THAT(rig.ask(state), ElementsAre(2, 0x01, 99, 0, 3, 0));
  EXPECT_THAT(rig.ask({3, 0x40, 99, 0, 0, 0}), testing::SizeIs(4));
  EXPECT_THAT(rig.ask(state), ElementsAre(2, 0x01, 99, 0, 0, 0)) << "cancelled";
  EXPECT_EQ(rig.ask({3, 0x40, 99, 0, 2, 0}), refused(4, 0x40, 99, 0x7008));
  rig.table.refusal = SoeError::kNotNow;
  EXPECT_EQ(rig.ask({3, 0x40, 99, 0, 3, 0}), refused(4, 0x40, 99, 0x7012));
  EXPECT_THAT(rig.ask(state), ElementsAre(2, 0x01, 99, 0, 0, 0));
  EXPECT_EQ(rig.table.started, 2);
}

TEST(SoeServer, SaysEmergenciesBehindTheFragmentsOfAnAnswer) {
  SoeRig rig;
  EXPECT_EQ(rig.ask({1, 0x4E, 1, 0})[0], 0x0AU);
  rig.table.say({1, wire::Emergency{0x8130, 0x10, {}}});
  EXPECT_EQ(rig.more()[0], 0x0AU);
  EXPECT_EQ(rig.more()[0], 0x02U);
  EXPECT_THAT(rig.more(), ElementsAre(0x26, 0, 0, 0, 0x30, 0x81, 0x10, 0, 0, 0, 0, 0));
}

TEST(SoeServer, KeepsTheNewestMessages) {
  SoeRig rig;
  for (std::uint16_t code = 0; code < 40; ++code) rig.table.say({0, wire::Emergency{code, 0, {}}});
  EXPECT_EQ(rig.more()[4], 24U);
  for (int i = 0; i < 15; ++i) EXPECT_FALSE(rig.more().empty());
  EXPECT_TRUE(rig.more().empty());
}

TEST(SoeServer, WhatIsNoRequestIsAMailboxError) {
  SoeRig rig;
  EXPECT_THAT(rig.ask({1, 0x40, 1}), ElementsAre(0xFFFF, 6)) << "too short";
  for (const unsigned first : {0U, 2U, 4U, 5U, 6U, 7U, 0x09U, 0x11U, 0x13U}) {
    EXPECT_THAT(rig.ask({first, 0x40, 1, 0}), ElementsAre(0xFFFF, 5)) << first;
  }
}

TEST(SoeServer, AMailboxWithoutRoomForAnAnswerIsAMailboxError) {
  SoeRig rig;
  const auto request = to_bytes({1, 0x40, 1, 0});
  for (std::size_t room = 0; room < 12; ++room) {
    std::vector<std::byte> out(room);
    EXPECT_EQ(rig.server.request({request, 12, wire::AlState::kPreOp}, out).error(),
              wire::MailboxErrorCode::kNoMoreMemory);
    EXPECT_EQ(rig.server.unsolicited(out), 0U);
  }
}

}  // namespace
}  // namespace driveline::slaves
