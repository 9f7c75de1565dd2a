#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

Bytes answered(unsigned index, unsigned sub) {
  return {0x60, index & 0xFF, index >> 8, sub, 0, 0, 0, 0};
}

Bytes with(Bytes head, std::size_t count, unsigned value) {
  head.insert(head.end(), count, value);
  return head;
}

std::string text(MailboxRig& rig) {
  return rig.dictionary.text(rig.dictionary.table().find(0x2003, 0)->slot);
}

TEST(SdoDownload, ExpeditedSizes) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x2F, 0x00, 0x20, 0, 0x55, 0xAA, 0xAA, 0xAA}), answered(0x2000, 0));
  EXPECT_EQ(rig.sdo({0x2B, 0x01, 0x20, 0, 0x55, 0x66, 0xAA, 0xAA}), answered(0x2001, 0));
  EXPECT_EQ(rig.sdo({0x23, 0x02, 0x20, 0, 0x55, 0x66, 0x77, 0x88}), answered(0x2002, 0));
  EXPECT_EQ(rig.sdo({0x40, 0x00, 0x20, 0, 0, 0, 0, 0})[4], 0x55U);
  EXPECT_EQ(rig.sdo({0x40, 0x01, 0x20, 0, 0, 0, 0, 0})[5], 0x66U);
  EXPECT_EQ(rig.sdo({0x40, 0x02, 0x20, 0, 0, 0, 0, 0})[7], 0x88U);
  EXPECT_EQ(rig.written_objects, (std::vector<unsigned>{0x2000, 0x2001, 0x2002}));
}

TEST(SdoDownload, ExpeditedWithoutSizeTakesWhatTheObjectNeeds) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x22, 0x01, 0x20, 0, 0x55, 0x66, 0, 0}), answered(0x2001, 0));
  EXPECT_EQ(rig.sdo({0x40, 0x01, 0x20, 0, 0, 0, 0, 0})[5], 0x66U);
}

TEST(SdoDownload, NormalTransferOfAShortValue) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x21, 0x02, 0x20, 0, 4, 0, 0, 0, 1, 2, 3, 4}), answered(0x2002, 0));
  EXPECT_EQ(rig.sdo({0x40, 0x02, 0x20, 0, 0, 0, 0, 0}), (Bytes{0x43, 0x02, 0x20, 0, 1, 2, 3, 4}));
}

TEST(SdoDownload, AnswerIsTheSameWhateverTheSizeBitsSay) {
  MailboxRig rig;
  for (const unsigned command : {0x22U, 0x23U, 0x26U, 0x2AU, 0x2EU}) {  // expedited, with and without a size
    EXPECT_EQ(rig.sdo({command, 0x02, 0x20, 0, 1, 2, 3, 4}), answered(0x2002, 0)) << command;
  }
  for (const unsigned command : {0x20U, 0x21U, 0x24U, 0x2DU}) {  // the complete size is there all the same
    EXPECT_EQ(rig.sdo({command, 0x02, 0x20, 0, 4, 0, 0, 0, 1, 2, 3, 4}), answered(0x2002, 0)) << command;
  }
}

TEST(SdoDownload, AbortsByReason) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x2F, 0x99, 0x20, 0, 1, 0, 0, 0}), aborted(0x2099, 0, 0x06020000));
  EXPECT_EQ(rig.sdo({0x23, 0x91, 0x60, 7, 1, 0, 0, 0}), aborted(0x6091, 7, 0x06090011));
  EXPECT_EQ(rig.sdo({0x2F, 0x06, 0x20, 0, 1, 0, 0, 0}), aborted(0x2006, 0, 0x06010002));
  EXPECT_EQ(rig.sdo({0x2F, 0x00, 0x20, 0, 0x80, 0, 0, 0}), aborted(0x2000, 0, 0x06090031));
  EXPECT_EQ(rig.sdo({0x2B, 0x01, 0x20, 0, 0x0F, 0, 0, 0}), aborted(0x2001, 0, 0x06090032));
  EXPECT_EQ(rig.sdo({0x2F, 0x01, 0x20, 0, 0x55, 0, 0, 0}), aborted(0x2001, 0, 0x06070013));
  EXPECT_EQ(rig.sdo({0x23, 0x01, 0x20, 0, 0x55, 0, 0, 0}), aborted(0x2001, 0, 0x06070012));
  EXPECT_EQ(rig.sdo({0x23, 0x08, 0x20, 0, 13, 0, 0, 0}), aborted(0x2008, 0, 0x08000021));  // the application
  EXPECT_EQ(rig.sdo({0x33, 0x91, 0x60, 0, 1, 0, 0, 0}), aborted(0x6091, 0, 0x06010004));
  rig.power = true;
  EXPECT_EQ(rig.sdo({0x23, 0x08, 0x20, 0, 1, 0, 0, 0}), aborted(0x2008, 0, 0x08000022));
  rig.state = wire::AlState::kSafeOp;
  EXPECT_EQ(rig.sdo({0x2F, 0x07, 0x20, 0, 1, 0, 0, 0}), aborted(0x2007, 0, 0x08000022));
  EXPECT_TRUE(rig.written_objects.empty());
}

TEST(SdoDownload, SegmentedString) {
  MailboxRig rig(48);  // 32 bytes with the initiate, up to 39 in a segment
  EXPECT_EQ(rig.sdo(with({0x21, 0x03, 0x20, 0, 0x4A, 0, 0, 0}, 32, 'a')), answered(0x2003, 0));
  EXPECT_EQ(rig.sdo(with({0x00}, 39, 'b')), (Bytes{0x20, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(text(rig), "X-Axis");                                                // not before it is complete
  EXPECT_EQ(rig.sdo(with({0x19}, 7, 'c')), (Bytes{0x30, 0, 0, 0, 0, 0, 0, 0}));  // 4 of 7 bytes unused
  EXPECT_EQ(text(rig), std::string(32, 'a') + std::string(39, 'b') + "ccc");
}

TEST(SdoDownload, AllDataInSegments) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x21, 0x03, 0x20, 0, 9, 0, 0, 0}), answered(0x2003, 0));
  EXPECT_EQ(rig.sdo({0x01, '1', '2', '3', '4', '5', '6', '7', '8', '9'})[0], 0x20U);
  EXPECT_EQ(text(rig), "123456789");
}

TEST(SdoDownload, AnnouncedSizeMustFitTheObject) {
  MailboxRig rig;
  EXPECT_EQ(rig.sdo({0x21, 0x03, 0x20, 0, 101, 0, 0, 0}), aborted(0x2003, 0, 0x06070012));
  EXPECT_EQ(rig.sdo({0x21, 0x03, 0x20, 0, 0xFF, 0xFF, 0xFF, 0xFF}), aborted(0x2003, 0, 0x06070012));
  EXPECT_EQ(rig.sdo({0x21, 0x02, 0x20, 0, 3, 0, 0, 0, 1, 2, 3}), aborted(0x2002, 0, 0x06070013));
}

TEST(SdoDownload, SegmentsThatDoNotAddUp) {
  const auto start = [](MailboxRig& rig) { rig.sdo({0x21, 0x03, 0x20, 0, 20, 0, 0, 0}); };
  MailboxRig more;
  start(more);
  EXPECT_EQ(more.sdo(with({0x01}, 21, 'a')), aborted(0x2003, 0, 0x06070012));
  MailboxRig less;
  start(less);
  EXPECT_EQ(less.sdo(with({0x01}, 19, 'a')), aborted(0x2003, 0, 0x06070013));
  MailboxRig toggle;
  start(toggle);
  EXPECT_EQ(toggle.sdo(with({0x10}, 10, 'a')), aborted(0x2003, 0, 0x05030000));
  EXPECT_EQ(toggle.sdo(with({0x00}, 10, 'a')), aborted(0, 0, 0x05040001));  // the transfer has ended
  MailboxRig none;
  EXPECT_EQ(none.sdo(with({0x00}, 7, 'a')), aborted(0, 0, 0x05040001));
  for (auto* rig : {&more, &less, &toggle, &none}) EXPECT_EQ(text(*rig), "X-Axis");
}

TEST(SdoDownload, UploadSegmentInADownloadIsAborted) {
  MailboxRig rig;
  rig.sdo({0x21, 0x03, 0x20, 0, 20, 0, 0, 0});
  EXPECT_EQ(rig.sdo({0x60, 0, 0, 0, 0, 0, 0, 0}), aborted(0x2003, 0, 0x05040001));
}

TEST(SdoDownload, StateIsCheckedAgainAtTheEnd) {
  MailboxRig rig;
  rig.sdo({0x21, 0x03, 0x20, 0, 8, 0, 0, 0});
  rig.state = wire::AlState::kInit;
  EXPECT_EQ(rig.sdo(with({0x01}, 8, 'a')), aborted(0x2003, 0, 0x08000022));
}

}  // namespace
}  // namespace driveline::slaves
