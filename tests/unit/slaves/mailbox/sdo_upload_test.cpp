#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;

Bytes with(Bytes head, std::string_view text, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) head.push_back(i < text.size() ? static_cast<unsigned char>(text[i]) : 0U);
  return head;
}

TEST(SdoUpload, ExpeditedSizesAndUnusedBytes) {
  MailboxRig rig;
  EXPECT_THAT(rig.sdo({0x40, 0x00, 0x20, 0, 0, 0, 0, 0}), ElementsAre(0x4F, 0x00, 0x20, 0, 0x11, 0, 0, 0));
  EXPECT_THAT(rig.sdo({0x40, 0x01, 0x20, 0, 0, 0, 0, 0}), ElementsAre(0x4B, 0x01, 0x20, 0, 0x11, 0x22, 0, 0));
  EXPECT_THAT(rig.sdo({0x40, 0x04, 0x20, 0, 0, 0, 0, 0}), ElementsAre(0x47, 0x04, 0x20, 0, 'M', 'S', 'D', 0));
  EXPECT_THAT(rig.sdo({0x40, 0x02, 0x20, 0, 0, 0, 0, 0}), ElementsAre(0x43, 0x02, 0x20, 0, 0x11, 0x22, 0x33, 0x44));
}

// MSD manual 8.2.4 shows this upload on CANopen: 41h, size 64h, then 15 segments of 7 bytes. CoE puts the first data
// after the size, and a segment is as long as the mailbox.
TEST(SdoUpload, StringThatFitsComesInOneMailbox) {
  MailboxRig rig(512);
  EXPECT_THAT(rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0}),
              ElementsAreArray(with({0x41, 0x03, 0x20, 0, 0x64, 0, 0, 0}, "X-Axis", 100)));
}

TEST(SdoUpload, LongStringIsSegmented) {
  MailboxRig rig(48);  // 40 bytes of SDO, 32 of them data; 39 in a segment
  EXPECT_THAT(rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0}),
              ElementsAreArray(with({0x41, 0x03, 0x20, 0, 0x64, 0, 0, 0}, "X-Axis", 32)));
  EXPECT_THAT(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), ElementsAreArray(with({0x00}, "", 39)));
  EXPECT_THAT(rig.sdo({0x70, 0, 0, 0, 0, 0, 0, 0}), ElementsAreArray(with({0x11}, "", 29)));
  EXPECT_THAT(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), ElementsAreArray(aborted(0, 0, 0x05040001)));  // it has ended
}

TEST(SdoUpload, ShortLastSegmentCountsItsUnusedBytes) {
  MailboxRig rig(42);  // 34 of SDO: 26 with the initiate, 33 in a segment; 100 = 26 + 33 + 33 + 8
  rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0});
  rig.sdo({0x70, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), with({0x01}, "", 8));
  MailboxRig seven(43);  // 27 + 34 + 34 + 5: a segment has 7 bytes at least, 2 of them unused
  seven.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  seven.sdo({0x60, 0, 0, 0, 0, 0, 0, 0});
  seven.sdo({0x70, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(seven.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), with({0x05}, "", 7));
}

TEST(SdoUpload, AbortsWhatCannotBeRead) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x40, 0x99, 0x20, 0, 0, 0, 0, 0}), aborted(0x2099, 0, 0x06020000));
  EXPECT_EQ(rig.sdo({0x40, 0x91, 0x60, 3, 0, 0, 0, 0}), aborted(0x6091, 3, 0x06090011));
  EXPECT_EQ(rig.sdo({0x40, 0x05, 0x20, 0, 0, 0, 0, 0}), aborted(0x2005, 0, 0x06010001));
  EXPECT_EQ(rig.sdo({0x50, 0x91, 0x60, 0, 0, 0, 0, 0}), aborted(0x6091, 0, 0x06010004));  // complete access
}

TEST(SdoUpload, AbortIsTenBytesOfCoe) {
  MailboxRig rig;
  rig.write({0x0A, 0, 0, 0, 0, 0x13, 0x00, 0x20, 0x40, 0x99, 0x20, 0x00, 0, 0, 0, 0});
  EXPECT_THAT(rig.read(),
              ElementsAre(0x0A, 0, 0, 0, 0, 0x13, 0x00, 0x20, 0x80, 0x99, 0x20, 0x00, 0x00, 0x00, 0x02, 0x06));
}

TEST(SdoUpload, WrongToggleEndsTheTransfer) {
  MailboxRig rig(48);
  rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.sdo({0x70, 0, 0, 0, 0, 0, 0, 0}), aborted(0x2003, 0, 0x05030000));
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), aborted(0, 0, 0x05040001));
}

TEST(SdoUpload, AbortFromTheMasterHasNoAnswerAndEndsTheTransfer) {
  MailboxRig rig(48);
  rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  EXPECT_TRUE(rig.sdo({0x80, 0x03, 0x20, 0, 0, 0, 0x04, 0x05}).empty());
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), aborted(0, 0, 0x05040001));
}

TEST(SdoUpload, ANewRequestEndsTheTransferBefore) {
  MailboxRig rig(48);
  rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x20, 0, 0, 0, 0, 0})[0], 0x4FU);
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), aborted(0, 0, 0x05040001));
}

TEST(SdoUpload, SegmentTakesTheDataOfTheMomentOfTheRequest) {
  MailboxRig rig(48);
  rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  rig.dictionary.text(0) = std::string(100, 'z');
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), with({0x00}, "", 39));
}

TEST(SdoUpload, UnknownCommandIsAborted) {
  MailboxRig rig;
  for (const unsigned command : {0xA0U, 0xC0U, 0xE0U, 0xFFU}) {
    EXPECT_EQ(rig.sdo({command, 0x00, 0x20, 0, 0, 0, 0, 0}), aborted(0x2000, 0, 0x05040001));
  }
}

}  // namespace
}  // namespace driveline::slaves
