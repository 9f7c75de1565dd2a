// The content of ESI and SII from the drive's table.
#include <algorithm>

#include "drive_rig.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdDescription, HasEveryObjectOfTheTable) {
  const auto description = MsdDrive::description();
  std::size_t entries = 0;
  for (const auto& object : description.objects) entries += object.entries.size();
  EXPECT_EQ(entries, dictionary_table().rows().size());
  const auto found = std::find_if(description.objects.begin(), description.objects.end(),
                                  [](const auto& object) { return object.index == 0x605E; });
  ASSERT_NE(found, description.objects.end());
  const auto& entry = found->entries.front();
  EXPECT_EQ(entry.default_hex, "0200");
  EXPECT_EQ(entry.minimum_hex, "FEFF");
  EXPECT_EQ(entry.maximum_hex, "0400");
  EXPECT_EQ(entry.bit_length, 16);
  EXPECT_TRUE(entry.writable);
  EXPECT_FALSE(entry.rx_mappable);
}

TEST(MsdDescription, SyncManagersOfSiiAndProfileAgree) {
  const auto description = MsdDrive::description();
  const MsdDrive drive;
  ASSERT_EQ(description.sync_managers.size(), drive.profile().sync_managers.size());
  for (std::size_t i = 0; i < description.sync_managers.size(); ++i) {
    EXPECT_EQ(description.sync_managers[i].start_address, drive.profile().sync_managers[i].start_address);
    EXPECT_EQ(description.sync_managers[i].default_size, drive.profile().sync_managers[i].default_length);
  }
  // control bytes as ETG.1000.6 expects them of a mailbox slave
  EXPECT_EQ(description.sync_managers[0].control, 0x26);
  EXPECT_EQ(description.sync_managers[1].control, 0x22);
  EXPECT_EQ(description.sync_managers[2].control, 0x64);
  EXPECT_EQ(description.sync_managers[3].control, 0x20);
}

TEST(MsdDescription, BuffersDoNotOverlapInTheMemory) {
  const MsdDrive drive;
  const auto& areas = drive.profile().sync_managers;
  for (std::size_t i = 0; i + 1 < areas.size(); ++i) {
    const unsigned buffers = i < 2 ? 1 : 3;  // process data are buffered three times
    EXPECT_LE(areas[i].start_address + buffers * areas[i].max_length, areas[i + 1].start_address);
  }
  EXPECT_LE(areas[3].start_address + 3U * areas[3].max_length, 0x1000U + 8U * 1024U);
}

TEST(MsdDescription, SiiImageIsValidAndIdentifiesTheDrive) {
  MsdParameters parameters;
  parameters.serial_number = 99;
  const MsdDrive drive(parameters);
  const auto image = esi::decode_sii(drive.profile().sii_image);
  ASSERT_TRUE(image.has_value());
  EXPECT_TRUE(image->checksum_valid());
  EXPECT_EQ(image->vendor_id, 0x28U);
  EXPECT_EQ(image->product_code, kProductCode);
  EXPECT_EQ(image->revision, kRevision);
  EXPECT_EQ(image->serial_number, 99U);
  EXPECT_EQ(image->standard_mailbox.receive_offset, 0x1000);
  EXPECT_EQ(image->standard_mailbox.send_size, 512);
  EXPECT_EQ(image->mailbox_protocols, 0x000E) << "EoE, CoE and FoE";
}

}  // namespace
}  // namespace driveline::slaves::msd
