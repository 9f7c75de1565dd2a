// Whole objects in one transfer. Layout of the first object as in ETG.1020 for records: sub-index 0 padded to 16 bits.
#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

using esi::DataType;
using esi::ObjectCode;
using testing::ElementsAre;

EntryRow row(std::uint16_t index, std::uint8_t sub, DataType type, std::uint16_t rights, double value = 0) {
  return {.index = index,
          .subindex = sub,
          .code = ObjectCode::kRecord,
          .type = type,
          .access = rights,
          .name = "Entry",
          .initial = value};
}

const DictionaryTable& table() {
  constexpr auto kRw = access::kReadWrite;
  static const auto kRows = [] {
    std::vector<EntryRow> rows = {
        row(0x8000, 0, DataType::kUnsigned8, access::kRead, 5),
        row(0x8000, 1, DataType::kBoolean, kRw, 1),
        row(0x8000, 2, DataType::kBit3, kRw, 5),
        row(0x8000, 3, DataType::kUnsigned16, kRw, 0x2211),
        row(0x8000, 4, DataType::kUnsigned32, access::kRead, 0x44332211),
        row(0x8000, 5, DataType::kUnsigned8, access::kWrite),
        // An assignment: entry 0 counts and can be written.
        row(0x1C12, 0, DataType::kUnsigned8, access::kReadWriteConfiguring, 1),
        row(0x1C12, 1, DataType::kUnsigned16, access::kReadWriteConfiguring, 0x1600),
        row(0x1C12, 2, DataType::kUnsigned16, access::kReadWriteConfiguring),
        // A long one: 100 texts of 20 bytes.
        row(0x9000, 0, DataType::kUnsigned8, access::kRead, 100),
        EntryRow{.index = 0x1000, .name = "Variable"},
        row(0x1018, 0, DataType::kUnsigned8, access::kRead, 1),
        row(0x1018, 1, DataType::kUnsigned32, access::kRead, 0x12345678),
    };
    rows[3].bit_offset = 32;  // where the description of the device puts it, 12 bits behind the entry before
    for (std::uint8_t sub = 1; sub <= 100; ++sub) {
      auto text = row(0x9000, sub, DataType::kVisibleString, kRw);
      text.string_length = 20;
      text.text = "text";
      rows.push_back(text);
    }
    return rows;
  }();
  static const DictionaryTable kTable({kRows}, 0);
  return kTable;
}

MailboxRig complete_rig(std::size_t size = 512) {
  return MailboxRig(size, table(), {.complete_access = true});
}

TEST(CompleteAccess, UploadsARecordWithItsLayout) {
  auto rig = complete_rig();
  // SI0 and padding; bits 1 and 101b, then nothing up to bit 32; the word; the long word; the write-only entry as 0
  EXPECT_THAT(rig.sdo({0x50, 0x00, 0x80, 0, 0, 0, 0, 0}),
              ElementsAre(0x51, 0x00, 0x80, 0, 11, 0, 0, 0, 5, 0, 0x0B, 0, 0x11, 0x22, 0x11, 0x22, 0x33, 0x44, 0));
  // From sub-index 1: the same without the first two bytes.
  EXPECT_THAT(rig.sdo({0x50, 0x00, 0x80, 1, 0, 0, 0, 0}),
              ElementsAre(0x51, 0x00, 0x80, 1, 9, 0, 0, 0, 0x0B, 0, 0x11, 0x22, 0x11, 0x22, 0x33, 0x44, 0));
}

TEST(CompleteAccess, ShortObjectsComeExpedited) {
  auto rig = complete_rig();
  EXPECT_THAT(rig.sdo({0x50, 0x12, 0x1C, 0, 0, 0, 0, 0}), ElementsAre(0x53, 0x12, 0x1C, 0, 1, 0, 0x00, 0x16));
  EXPECT_THAT(rig.sdo({0x50, 0x18, 0x10, 1, 0, 0, 0, 0}), ElementsAre(0x53, 0x18, 0x10, 1, 0x78, 0x56, 0x34, 0x12));
}

TEST(CompleteAccess, DownloadsARecordAndPassesOverReadOnlyEntries) {
  auto rig = complete_rig();
  EXPECT_THAT(rig.sdo({0x31, 0x00, 0x80, 0, 11, 0, 0, 0, 5, 0, 0x06, 0, 0xAA, 0xBB, 0xFF, 0xFF, 0xFF, 0xFF, 0x77}),
              ElementsAre(0x60, 0x00, 0x80, 0, 0, 0, 0, 0));
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 1, 0, 0, 0, 0})[4], 0U);
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 2, 0, 0, 0, 0})[4], 3U);
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 3, 0, 0, 0, 0})[5], 0xBBU);
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 4, 0, 0, 0, 0})[7], 0x44U);
  EXPECT_EQ(rig.dictionary.raw(*table().find(0x8000, 5)), 0x77U);
}

TEST(CompleteAccess, AFailedDownloadChangesNothing) {
  auto rig = complete_rig();
  EXPECT_EQ(rig.sdo({0x31, 0x00, 0x80, 1, 9, 0, 0, 0, 0x06, 0, 13, 0, 0, 0, 0, 0, 0}),
            aborted(0x8000, 1, 0x08000021));  // the application refuses the word
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 1, 0, 0, 0, 0})[4], 1U);
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x80, 2, 0, 0, 0, 0})[4], 5U);
}

TEST(CompleteAccess, WritesAnAssignmentInTheOrderItAsksFor) {
  auto rig = complete_rig();
  EXPECT_THAT(rig.sdo({0x31, 0x12, 0x1C, 0, 6, 0, 0, 0, 2, 0, 0x01, 0x16, 0x02, 0x16}),
              ElementsAre(0x60, 0x12, 0x1C, 0, 0, 0, 0, 0));
  EXPECT_THAT(rig.written_objects, ElementsAre(0x1C12, 0x1C12, 0x1C12, 0x1C12));  // 0, entries, count
  EXPECT_THAT(rig.sdo({0x50, 0x12, 0x1C, 0, 0, 0, 0, 0}),
              ElementsAre(0x51, 0x12, 0x1C, 0, 6, 0, 0, 0, 2, 0, 0x01, 0x16, 0x02, 0x16));
  // No entry at all: two bytes, expedited.
  EXPECT_EQ(rig.sdo({0x3B, 0x12, 0x1C, 0, 0, 0, 0, 0})[0], 0x60U);
  EXPECT_THAT(rig.sdo({0x50, 0x12, 0x1C, 0, 0, 0, 0, 0}), ElementsAre(0x5B, 0x12, 0x1C, 0, 0, 0, 0, 0));
}

TEST(CompleteAccess, LengthMustFitTheCount) {
  auto rig = complete_rig();
  EXPECT_EQ(rig.sdo({0x31, 0x12, 0x1C, 0, 4, 0, 0, 0, 2, 0, 0x01, 0x16}), aborted(0x1C12, 0, 0x06070013));
  EXPECT_EQ(rig.sdo({0x31, 0x12, 0x1C, 0, 7, 0, 0, 0, 2, 0, 1, 0x16, 2, 0x16, 0}), aborted(0x1C12, 0, 0x06070012));
  EXPECT_EQ(rig.sdo({0x31, 0x00, 0x80, 0, 10, 0, 0, 0, 5, 0, 6, 0, 1, 2, 3, 4, 5, 6}), aborted(0x8000, 0, 0x06070013));
  EXPECT_EQ(rig.sdo({0x50, 0x12, 0x1C, 0, 0, 0, 0, 0})[4], 1U);
}

TEST(CompleteAccess, AbortsByReason) {
  auto rig = complete_rig();
  EXPECT_EQ(rig.sdo({0x50, 0x99, 0x20, 0, 0, 0, 0, 0}), aborted(0x2099, 0, 0x06020000));
  EXPECT_EQ(rig.sdo({0x50, 0x00, 0x80, 2, 0, 0, 0, 0}), aborted(0x8000, 2, 0x06010000));  // only from 0 or 1
  EXPECT_EQ(rig.sdo({0x50, 0x00, 0x10, 0, 0, 0, 0, 0}), aborted(0x1000, 0, 0x06010000));  // a variable
  EXPECT_EQ(rig.sdo({0x33, 0x18, 0x10, 1, 1, 2, 3, 4}), aborted(0x1018, 1, 0x06010002));
  rig.state = wire::AlState::kSafeOp;
  EXPECT_EQ(rig.sdo({0x33, 0x12, 0x1C, 0, 1, 0, 1, 0x16}), aborted(0x1C12, 0, 0x08000022));
}

TEST(CompleteAccess, LongObjectsGoSegmentedBothWays) {
  auto rig = complete_rig(128);  // 112 bytes of data in the first mailbox, 119 in a segment
  Bytes first = rig.sdo({0x50, 0x00, 0x90, 0, 0, 0, 0, 0});
  ASSERT_GE(first.size(), 8U);
  EXPECT_EQ(first[4] + 256 * first[5], 2002U);
  Bytes data(first.begin() + 8, first.end());
  unsigned toggle = 0;
  for (bool last = false; !last; toggle ^= 0x10) {
    const Bytes segment = rig.sdo({0x60 | toggle, 0, 0, 0, 0, 0, 0, 0});
    ASSERT_FALSE(segment.empty());
    last = (segment[0] & 1) != 0;
    data.insert(data.end(), segment.begin() + 1, segment.end() - static_cast<std::ptrdiff_t>(segment[0] >> 1 & 7U));
  }
  ASSERT_EQ(data.size(), 2002U);
  EXPECT_EQ(data[0], 100U);
  for (std::size_t i = 2; i < data.size(); i += 20) EXPECT_EQ(data[i], unsigned{'t'});

  for (std::size_t i = 2; i < data.size(); ++i) data[i] = static_cast<unsigned>('a' + (i - 2) / 20 % 26);
  Bytes start = {0x31, 0x00, 0x90, 0, 2002 & 0xFF, 2002 >> 8, 0, 0};
  start.insert(start.end(), data.begin(), data.begin() + 100);
  EXPECT_EQ(rig.sdo(start)[0], 0x60U);
  toggle = 0;
  for (std::size_t at = 100; at < data.size(); toggle ^= 0x10) {
    const auto count = static_cast<unsigned>(std::min<std::size_t>(100, data.size() - at));
    Bytes segment = {toggle | (at + count == data.size() ? 1U : 0U) | (count < 7 ? (7 - count) << 1 : 0U)};
    segment.insert(segment.end(), data.begin() + static_cast<std::ptrdiff_t>(at),
                   data.begin() + static_cast<std::ptrdiff_t>(at + count));
    segment.resize(std::max<std::size_t>(segment.size(), 8));
    EXPECT_EQ(rig.sdo(segment)[0], 0x20U | toggle);
    at += count;
  }
  EXPECT_EQ(rig.dictionary.text(table().find(0x9000, 1)->slot), std::string(20, 'a'));
  EXPECT_EQ(rig.dictionary.text(table().find(0x9000, 100)->slot), std::string(20, 'a' + 99 % 26));
}

TEST(CompleteAccess, IsRefusedByADeviceWithoutIt) {
  MailboxRig rig(512, table(), {});
  EXPECT_EQ(rig.sdo({0x50, 0x00, 0x80, 0, 0, 0, 0, 0}), aborted(0x8000, 0, 0x06010004));
  EXPECT_EQ(rig.sdo({0x3B, 0x12, 0x1C, 0, 0, 0, 0, 0}), aborted(0x1C12, 0, 0x06010004));
}

TEST(CoeServerOptions, WithoutSdoInformationTheServiceIsNotSupported) {
  MailboxRig rig(512, table(), {.sdo_information = false});
  rig.write({8, 0, 0, 0, 0, 0x13, 0x00, 0x80, 1, 0, 0, 0, 1, 0});
  EXPECT_THAT(rig.read(), ElementsAre(4, 0, 0, 0, 0, 0x10, 1, 0, 4, 0));  // mailbox error: service not supported
}

}  // namespace
}  // namespace driveline::slaves
