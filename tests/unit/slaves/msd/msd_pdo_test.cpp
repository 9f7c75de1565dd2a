// PDO mapping and assignment of the drive over CoE.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdPdo, MappingIsEmptyInTheFactorySetting) {
  DriveRig rig;
  for (const std::uint16_t first : {std::uint16_t{0x1600}, std::uint16_t{0x1A00}}) {
    for (std::uint16_t pdo = first; pdo < first + 4; ++pdo) EXPECT_EQ(rig.read(pdo), 0U);
  }
  EXPECT_EQ(rig.device.process_data_size(2), 0U);
  EXPECT_EQ(rig.device.process_data_size(3), 0U);
  EXPECT_EQ(rig.read(0x1C12), 4U);
  EXPECT_EQ(rig.read(0x1C13, 4), 0x1A03U);
}

TEST(MsdPdo, SizeFollowsMappingAndAssignment) {
  DriveRig rig;
  rig.map(0x1600, {0x60400010, 0x607A0020});
  rig.map(0x1601, {0x60FF0020});
  rig.map(0x1A00, {0x60410010});
  EXPECT_EQ(rig.device.process_data_size(2), 10U);
  EXPECT_EQ(rig.device.process_data_size(3), 2U);
  EXPECT_EQ(rig.device.process_data_size(0), 0U);
  ASSERT_EQ(rig.write(0x1C12, 0, 0, 1), 0U);
  EXPECT_EQ(rig.device.process_data_size(2), 0U);
  rig.set({{0x1C12, 1, 0x1601, 2}, {0x1C12, 0, 1, 1}});
  EXPECT_EQ(rig.device.process_data_size(2), 4U);
}

TEST(MsdPdo, AtMostEightBytes) {
  DriveRig rig;
  rig.set({{0x1600, 1, 0x60400010, 4}, {0x1600, 2, 0x607A0020, 4}, {0x1600, 3, 0x60FF0020, 4}});
  EXPECT_EQ(rig.write(0x1600, 0, 3, 1), 0x06040042U);
  EXPECT_EQ(rig.write(0x1600, 0, 2, 1), 0U);
}

TEST(MsdPdo, RefusesWhatCannotBeMapped) {
  DriveRig rig;
  EXPECT_EQ(rig.write(0x1600, 1, 0x60410010, 4), 0x06040041U);  // status word in an RxPDO
  EXPECT_EQ(rig.write(0x1A00, 1, 0x605A0010, 4), 0x06040041U);  // option code
  EXPECT_EQ(rig.write(0x1600, 1, 0x60400020, 4), 0x06040041U);  // wrong length
  EXPECT_EQ(rig.write(0x1600, 1, 0x5FFF0010, 4), 0x06020000U);
  EXPECT_EQ(rig.write(0x1600, 1, 0x60400110, 4), 0x06090011U);
  EXPECT_EQ(rig.write(0x1600, 9, 0x60400010, 4), 0x06090011U);
  EXPECT_EQ(rig.write(0x1604, 0, 0, 1), 0x06020000U);
}

TEST(MsdPdo, MappingOnlyInPreOp) {
  OperatingRig rig;
  for (const std::uint16_t object :
       {std::uint16_t{0x1600}, std::uint16_t{0x1A03}, std::uint16_t{0x1C12}, std::uint16_t{0x1C13}}) {
    EXPECT_EQ(rig.write(object, 0, 0, 1), 0x08000022U);
  }
  rig.to(AlState::kOp, AlState::kSafeOp);
  EXPECT_EQ(rig.write(0x1600, 0, 0, 1), 0x08000022U);
  rig.to(AlState::kSafeOp, AlState::kPreOp);
  EXPECT_EQ(rig.write(0x1600, 0, 0, 1), 0U);
}

TEST(MsdPdo, OddByteCountNeedsNoFiller) {
  DriveRig rig;
  rig.map(0x1600, {0x60600008});
  EXPECT_EQ(rig.device.process_data_size(2), 1U);
}

// The dialogue of a SOEM master with a real drive with the same object layout (soem-sdinfo-akd, packets 281 to 352);
// the answers of this drive must be the same bytes.
TEST(MsdPdo, AnswersTheAssignmentScanLikeARealDrive) {
  DriveRig rig;
  rig.map(0x1600, {0x60400010});
  const auto expect = [&](std::vector<unsigned> request, const std::vector<unsigned>& answer) {
    EXPECT_EQ(rig.sdo(std::move(request)), answer);
  };
  expect({0x40, 0x00, 0x1c, 0, 0, 0, 0, 0}, {0x4f, 0x00, 0x1c, 0x00, 0x04, 0, 0, 0});
  expect({0x40, 0x00, 0x1c, 3, 0, 0, 0, 0}, {0x4f, 0x00, 0x1c, 0x03, 0x03, 0, 0, 0});
  expect({0x40, 0x12, 0x1c, 0, 0, 0, 0, 0}, {0x4f, 0x12, 0x1c, 0x00, 0x04, 0, 0, 0});
  expect({0x40, 0x12, 0x1c, 1, 0, 0, 0, 0}, {0x4b, 0x12, 0x1c, 0x01, 0x00, 0x16, 0, 0});
  expect({0x40, 0x00, 0x16, 0, 0, 0, 0, 0}, {0x4f, 0x00, 0x16, 0x00, 0x01, 0, 0, 0});
  expect({0x40, 0x00, 0x16, 1, 0, 0, 0, 0}, {0x43, 0x00, 0x16, 0x01, 0x10, 0x00, 0x40, 0x60});
  expect({0x40, 0x12, 0x1c, 2, 0, 0, 0, 0}, {0x4b, 0x12, 0x1c, 0x02, 0x01, 0x16, 0, 0});
}

}  // namespace
}  // namespace driveline::slaves::msd
