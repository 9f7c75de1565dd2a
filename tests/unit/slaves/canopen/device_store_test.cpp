#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

// C45: "save" and "load"; load acts after a reset.
TEST_F(CanopenDevice, C45SaveAndLoad) {
  ASSERT_EQ(rig.write(0x2000, 0, 0x1234, 2), 0U);
  ASSERT_EQ(rig.write(0x2001, 0, 99, 1), 0U);  // is not stored
  ASSERT_EQ(rig.write(0x1006, 0, 4000, 4), 0U);
  rig.map(0x1801, {0x2001'0008}, 7);
  EXPECT_EQ(rig.ask("23 10 10 01 73 61 76 65"), hex("60 10 10 01 00 00 00 00"));
  ASSERT_EQ(rig.write(0x2000, 0, 0x1111, 2), 0U);
  rig.nmt(canopen::NmtCommand::kResetNode);
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  EXPECT_EQ(rig.value(0x2001), 5U);
  EXPECT_EQ(rig.value(0x1006), 4000U);
  EXPECT_EQ(rig.value(0x1801, 2), 7U);
  EXPECT_EQ(rig.value(0x1A01, 1), 0x2001'0008U);
  EXPECT_EQ(rig.ask("23 11 10 01 6C 6F 61 64"), hex("60 11 10 01 00 00 00 00"));
  EXPECT_EQ(rig.value(0x2000), 0x1234U);
  rig.nmt(canopen::NmtCommand::kResetNode);
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
  EXPECT_EQ(rig.value(0x1006), 0U);
  EXPECT_EQ(rig.value(0x1A01, 0), 0U);
}

TEST_F(CanopenDevice, C45WrongSignature) {
  EXPECT_EQ(rig.ask("23 10 10 01 6C 6F 61 64"), hex("80 10 10 01 20 00 00 08"));  // "load" does not save
  EXPECT_EQ(rig.ask("23 11 10 01 73 61 76 65"), hex("80 11 10 01 20 00 00 08"));
  EXPECT_EQ(rig.read(0x1010, 1), 1U);
}

// A refusal of the application keeps the stored values.
TEST_F(CanopenDevice, C45TheApplicationMayRefuse) {
  ASSERT_EQ(rig.write(0x2000, 0, 0x1234, 2), 0U);
  rig.application.verdict = tl::unexpected(sdo::SdoAbort::kDeviceState);
  EXPECT_EQ(rig.ask("23 10 10 01 73 61 76 65"), hex("80 10 10 01 22 00 00 08"));
  rig.application.verdict = {};
  rig.nmt(canopen::NmtCommand::kResetNode);
  EXPECT_EQ(static_cast<std::int64_t>(rig.value(0x2000)), -17);
}

// COB-IDs that count from the node-ID do so after they were stored with another one; others stay as they are.
TEST_F(CanopenDevice, C45StoredCobIdsFollowTheNodeId) {
  ASSERT_EQ(rig.write(0x1801, 1, 0x8000'0285, 4), 0U);
  ASSERT_EQ(rig.write(0x1801, 1, 0x0000'0234, 4), 0U);
  ASSERT_EQ(rig.ask("23 10 10 01 73 61 76 65"), hex("60 10 10 01 00 00 00 00"));
  rig.application.next_node = 9;
  rig.nmt(canopen::NmtCommand::kResetNode);
  EXPECT_EQ(rig.value(0x1800, 1), 0x189U);
  EXPECT_EQ(rig.value(0x1801, 1), 0x234U);
  EXPECT_EQ(rig.value(0x1014), 0x089U);
}

TEST(CanopenStore, ValuesOfAFileAreThereFromTheStart) {
  ObjectDictionary stored(sample_table());
  stored.set_raw(stored.table().find(0x2000, 0)->slot, 0x77);
  DeviceRig rig;
  rig.device.store().load(stored);
  rig.run(2ms);
  EXPECT_EQ(rig.value(0x2000), 0x77U);
}

}  // namespace
}  // namespace driveline::slaves::cia301
