#include "mailbox_rig.hpp"

namespace driveline::slaves {
namespace {

/// Service data of an SDO information request: CoE service 8, header, body.
Bytes info(MailboxRig& rig, unsigned op, Bytes body) {
  Bytes request = {0x00, 0x80, op, 0, 0, 0};
  request.insert(request.end(), body.begin(), body.end());
  return rig.coe(request);
}

Bytes text(Bytes head, std::string_view name) {
  for (const char c : name) head.push_back(static_cast<unsigned char>(c));
  return head;
}

TEST(SdoInformation, ListsAllObjects) {
  MailboxRig rig;
  EXPECT_EQ(info(rig, 1, {1, 0}),
            (Bytes{0x00, 0x80, 2,    0,    0,    0,    1,    0,    0x18, 0x10, 0x00, 0x20, 0x01, 0x20, 0x02,
                   0x20, 0x03, 0x20, 0x04, 0x20, 0x05, 0x20, 0x06, 0x20, 0x07, 0x20, 0x08, 0x20, 0x91, 0x60}));
}

TEST(SdoInformation, ListsByUse) {
  MailboxRig rig;
  EXPECT_EQ(info(rig, 1, {2, 0}), (Bytes{0x00, 0x80, 2, 0, 0, 0, 2, 0, 0x01, 0x20}));  // RxPDO
  EXPECT_EQ(info(rig, 1, {3, 0}), (Bytes{0x00, 0x80, 2, 0, 0, 0, 3, 0, 0x91, 0x60}));  // TxPDO
  EXPECT_EQ(info(rig, 1, {4, 0}), (Bytes{0x00, 0x80, 2, 0, 0, 0, 4, 0, 0x03, 0x20}));  // stored
  EXPECT_EQ(info(rig, 1, {5, 0}), (Bytes{0x00, 0x80, 2, 0, 0, 0, 5, 0}));
  EXPECT_EQ(info(rig, 1, {0, 0}), (Bytes{0x00, 0x80, 2, 0, 0, 0, 0, 0, 11, 0, 1, 0, 1, 0, 1, 0, 0, 0}));
}

TEST(SdoInformation, LongListComesInFragments) {
  MailboxRig rig(34);  // 22 bytes of list data in a mailbox: 24 bytes of list need two
  EXPECT_EQ(info(rig, 1, {1, 0}),
            (Bytes{0x00, 0x80, 0x82, 0,    1,    0,    1,    0,    0x18, 0x10, 0x00, 0x20, 0x01, 0x20,
                   0x02, 0x20, 0x03, 0x20, 0x04, 0x20, 0x05, 0x20, 0x06, 0x20, 0x07, 0x20, 0x08, 0x20}));
  EXPECT_EQ(MailboxRig::service_data(rig.read()), (Bytes{0x00, 0x80, 0x02, 0, 0, 0, 0x91, 0x60}));
  EXPECT_TRUE(rig.read().empty());
}

TEST(SdoInformation, DescribesObjects) {
  MailboxRig rig;
  EXPECT_EQ(info(rig, 3, {0x03, 0x20}),
            text({0x00, 0x80, 4, 0, 0, 0, 0x03, 0x20, 0x09, 0x00, 0, 7}, "DV_DeviceAliasName"));
  EXPECT_EQ(info(rig, 3, {0x91, 0x60}), text({0x00, 0x80, 4, 0, 0, 0, 0x91, 0x60, 0x07, 0x00, 2, 8}, "Gear ratio"));
  EXPECT_EQ(info(rig, 3, {0x18, 0x10}), text({0x00, 0x80, 4, 0, 0, 0, 0x18, 0x10, 0x23, 0x00, 0, 9}, "Identity"));
}

TEST(SdoInformation, DescribesEntries) {
  MailboxRig rig;
  // value info 0; type U16, 16 bits, readable and writable in all states, RxPDO-mappable
  EXPECT_EQ(info(rig, 5, {0x01, 0x20, 0, 0}),
            text({0x00, 0x80, 6, 0, 0, 0, 0x01, 0x20, 0, 0, 0x06, 0x00, 16, 0, 0x7F, 0x00}, "Word"));
  // default, minimum and maximum where they exist
  EXPECT_EQ(info(rig, 5, {0x91, 0x60, 1, 0x70}), text({0x00, 0x80, 6, 0, 0, 0, 0x91, 0x60, 1, 0x70, 0x07, 0x00, 32, 0,
                                                       0x3F, 0x00, 1, 0, 0, 0, 1,    0,    0, 0,    0xE8, 3,    0,  0},
                                                      "Motor"));
  EXPECT_EQ(info(rig, 5, {0x91, 0x60, 2, 0x7F}),
            text({0x00, 0x80, 6, 0, 0, 0, 0x91, 0x60, 2, 0x17, 0x07, 0x00, 32, 0, 0xBF, 0x00, 0, 0, 0, 0}, "Shaft"));
  EXPECT_EQ(info(rig, 5, {0x91, 0x60, 0, 0x00}),
            text({0x00, 0x80, 6, 0, 0, 0, 0x91, 0x60, 0, 0, 0x05, 0x00, 8, 0, 0x07, 0x00}, "Number of entries"));
  EXPECT_EQ(info(rig, 5, {0x03, 0x20, 0, 0x10}),
            text({0x00, 0x80, 6, 0, 0, 0, 0x03, 0x20, 0, 0, 0x09, 0x00, 0x20, 0x03, 0x3F, 0x01}, "DV_DeviceAliasName"));
}

TEST(SdoInformation, ReportsErrors) {
  MailboxRig rig;
  const auto error = [](std::uint32_t code) {
    return Bytes{0x00, 0x80, 7, 0, 0, 0, code & 0xFF, code >> 8 & 0xFF, code >> 16 & 0xFF, code >> 24};
  };
  EXPECT_EQ(info(rig, 3, {0x99, 0x20}), error(0x06020000));
  EXPECT_EQ(info(rig, 5, {0x99, 0x20, 0, 0}), error(0x06020000));
  EXPECT_EQ(info(rig, 5, {0x91, 0x60, 9, 0}), error(0x06090011));
  EXPECT_EQ(info(rig, 1, {6, 0}), error(0x06010000));
  EXPECT_EQ(info(rig, 1, {1}), error(0x05040001));
  EXPECT_EQ(info(rig, 3, {}), error(0x05040001));
  EXPECT_EQ(info(rig, 5, {0x91, 0x60, 1}), error(0x05040001));
  EXPECT_EQ(info(rig, 2, {1, 0}), error(0x05040001));
  EXPECT_EQ(info(rig, 0x7F, {1, 0}), error(0x05040001));
}

TEST(SdoInformation, LongNameIsCutAtTheMailbox) {
  MailboxRig rig(28);
  EXPECT_EQ(info(rig, 3, {0x03, 0x20}), text({0x00, 0x80, 4, 0, 0, 0, 0x03, 0x20, 0x09, 0x00, 0, 7}, "DV_DeviceA"));
}

TEST(SdoInformation, ARequestWaitsForTheRestOfTheList) {
  MailboxRig rig(34);
  info(rig, 1, {1, 0});
  EXPECT_EQ(info(rig, 3, {0x18, 0x10}), (Bytes{0x00, 0x80, 0x02, 0, 0, 0, 0x91, 0x60}));  // the list's second half
  EXPECT_EQ(MailboxRig::service_data(rig.read()).at(2), 4U);                              // then the answer
}

}  // namespace
}  // namespace driveline::slaves
