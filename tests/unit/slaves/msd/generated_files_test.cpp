// The device files in esi/data are generated; here they are compared with what the object dictionary says now.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "driveline/esi/eds_file.hpp"
#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/msd/msd_table.hpp"

namespace driveline::slaves::msd {
namespace {

/// Tests run in the top folder of the project.
std::string content(const std::string& name) {
  std::ifstream file(std::filesystem::path("esi/data") / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(GeneratedDeviceFiles, EsiFileIsWhatTheTableSays) {
  EXPECT_TRUE(content("moog_msd.xml") == esi::write_esi({esi_description()}))
      << "regenerate: build/driveline esi generate esi/data";
}

TEST(GeneratedDeviceFiles, SiiImageIsWhatTheTableSays) {
  std::string image;
  for (const auto byte : esi::encode_sii(esi::make_sii(device_description()))) image += static_cast<char>(byte);
  EXPECT_TRUE(content("moog_msd.sii") == image) << "regenerate: build/driveline esi generate esi/data";
}

TEST(GeneratedDeviceFiles, EdsIsWhatTheTableSays) {
  EXPECT_TRUE(content("moog_msd.eds") == esi::write_eds(device_description(), "moog_msd.eds"))
      << "regenerate: build/driveline esi generate esi/data";
}

TEST(GeneratedDeviceFiles, ObjectPageIsWhatTheTableSays) {
  EXPECT_TRUE(content("moog_msd_objects.md") == object_reference())
      << "regenerate: build/driveline esi generate esi/data";
}

TEST(GeneratedDeviceFiles, FilesOfTheServoOneAreWhatItsTablesSay) {
  const auto one = device_description(Variant::kServoOne);
  const auto junior = device_description(Variant::kServoOneJunior);
  EXPECT_TRUE(content("servoone.xml") ==
              esi::write_esi({esi_description(Variant::kServoOne), esi_description(Variant::kServoOneJunior)}))
      << "regenerate";
  EXPECT_TRUE(content("servoone.eds") == esi::write_eds(one, "servoone.eds")) << "regenerate";
  EXPECT_TRUE(content("servoone_junior.eds") == esi::write_eds(junior, "servoone_junior.eds")) << "regenerate";
  EXPECT_TRUE(content("servoone_objects.md") == object_reference(Variant::kServoOne)) << "regenerate";
  for (const auto& [name, device] : {std::pair("servoone.sii", one), std::pair("servoone_junior.sii", junior)}) {
    std::string image;
    for (const auto byte : esi::encode_sii(esi::make_sii(device))) image += static_cast<char>(byte);
    EXPECT_TRUE(content(name) == image) << name << ": regenerate";
  }
}

TEST(GeneratedDeviceFiles, EveryRowIsOnTheObjectPageAndInTheEds) {
  const std::string page = content("moog_msd_objects.md");
  const std::string eds = content("moog_msd.eds");
  const auto rows = dictionary_table().rows();
  EXPECT_EQ(static_cast<std::size_t>(std::count(page.begin(), page.end(), '\n')), rows.size() + 7);
  std::size_t entries = 0;
  for (auto at = eds.find("AccessType="); at != std::string::npos; at = eds.find("AccessType=", at + 1)) ++entries;
  EXPECT_EQ(entries, rows.size());
}

TEST(GeneratedDeviceFiles, EsiFileReadsBackWithIdentityAndPdos) {
  const auto file = esi::read_esi(content("moog_msd.xml"), "moog_msd.xml");
  ASSERT_TRUE(file) << esi::to_text(file.error());
  const auto* device = file->find_device(kVendorId, kProductCode, kRevision);
  ASSERT_NE(device, nullptr);
  EXPECT_EQ(device->rx_pdos.size(), 4U);
  EXPECT_EQ(device->tx_pdos.size(), 4U);
}

}  // namespace
}  // namespace driveline::slaves::msd
