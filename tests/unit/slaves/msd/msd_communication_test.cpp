// Data types, addresses and transfers of the drive (MSD manual 8.2), and the data set after a download (8.2.5).
#include <set>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdCommunication, TypesAreThoseOfTheTableOfDataTypes) {
  using enum esi::DataType;
  const std::set<esi::DataType> manual = {kUnsigned8, kUnsigned16, kUnsigned32, kInteger8,
                                          kInteger16, kInteger32,  kReal32,     kVisibleString};
  std::set<esi::DataType> used;
  for (const auto& row : dictionary_table().rows()) {
    const bool synchronisation = row.index == 0x1C32 || row.index == 0x1C33;
    if (!synchronisation) used.insert(row.type);  // "Sync error" is a BOOL of ETG.1020
  }
  EXPECT_EQ(used, manual);
}

TEST(MsdCommunication, ManufacturerObjectsLieFrom2000hTo5FFFh) {
  for (const auto& row : dictionary_table().rows()) {
    const bool manufacturer = row.index >= 0x2000 && row.index <= 0x5FFF;
    const bool communication = row.index >= 0x1000 && row.index <= 0x1FFF;
    const bool profile = row.index >= 0x6000 && row.index <= 0x67FF;
    EXPECT_EQ(int{manufacturer} + int{communication} + int{profile}, 1) << std::hex << row.index;
    // Names of parameters are the manual's MPRO_, CON_, MOT_ ...: none of them is at an address of the standard.
    const bool parameter_name =
        row.name.starts_with("MPRO_") || row.name.starts_with("CON_") || row.name.starts_with("COM_");
    EXPECT_TRUE(!parameter_name || manufacturer) << row.name;
  }
}

TEST(MsdCommunication, SegmentsMayComeSixteenSecondsApart) {
  DriveRig rig;
  const std::string name = "Axis that waits";
  // Normal download of 15 bytes without data in the first mailbox, then two segments.
  auto answer = rig.sdo({0x21, 0x03, 0x20, 0, 15, 0, 0, 0});
  ASSERT_EQ(answer.at(0), 0x60U);
  std::vector<unsigned> first = {0x00};
  std::vector<unsigned> second = {0x10 | 0x01};
  for (std::size_t i = 0; i < name.size(); ++i) {
    (i < 7 ? first : second).push_back(static_cast<unsigned char>(name[i]));
  }
  rig.pass(17s);
  answer = rig.sdo(first);
  ASSERT_EQ(answer.at(0), 0x20U);
  rig.pass(17s);
  answer = rig.sdo(second);
  ASSERT_EQ(answer.at(0), 0x30U);
  answer = rig.sdo({0x40, 0x03, 0x20, 0, 0, 0, 0, 0});
  std::string read;
  for (std::size_t i = 8; i < 8 + name.size(); ++i) read += static_cast<char>(answer.at(i));
  EXPECT_EQ(read, name);
}

TEST(MsdParameterService, DownloadedSetIsSavedAfterwards) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x200B, 4, 1, 1), 0U);
  ASSERT_EQ(rig.write(0x607D, 1, 5000, 4), 0U) << "above the upper limit that is there yet";
  rig.set({{0x607D, 2, 9000, 4}, {0x200B, 4, 0, 1}});
  ASSERT_EQ(rig.drive.fault(), std::nullopt);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  rig.pass(5ms);
  rig.restart();
  EXPECT_EQ(rig.read(0x607D, 1), 5000U);
  EXPECT_EQ(rig.read(0x607D, 2), 9000U);
  EXPECT_EQ(rig.read(0x200B, 4), 0U) << "the check is on again";
}

}  // namespace
}  // namespace driveline::slaves::msd
