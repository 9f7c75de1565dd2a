// The ESI files in esi/data are generated; here they are compared with the present object dictionary.

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
#include "support/must.hpp"

namespace driveline::slaves::msd {
namespace {

/// Tests run in the top folder of the project.
std::string content(const std::string& name) {
  std::ifstream file(std::filesystem::path("esi/data") / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(GeneratedDeviceFiles, EsiFileIsWhatTheTableSays) {
  EXPECT_TRUE(content("moog_msd.xml") == esi::write_esi({esi_description()}))
      << "regenerate: cmake --build build --target regenerate";
}

TEST(GeneratedDeviceFiles, EsiFileOfTheServoOneIsWhatItsTablesSay) {
  EXPECT_TRUE(content("servoone.xml") ==
              esi::write_esi({esi_description(Variant::kServoOne), esi_description(Variant::kServoOneJunior)}))
      << "regenerate: cmake --build build --target regenerate";
}

TEST(GeneratedDeviceFiles, SiiImageReadsBackWithIdentity) {
  for (const auto& variant : kVariants) {
    const auto image = must(esi::decode_sii(esi::encode_sii(esi::make_sii(device_description(variant.variant)))));
    EXPECT_TRUE(image->checksum_valid());
    const auto device = esi::description_from_sii(*image);
    EXPECT_EQ(device.vendor_id, kVendorId);
    EXPECT_EQ(device.product_code, variant.product_code);
    EXPECT_EQ(device.revision, variant.revision);
  }
}

TEST(GeneratedDeviceFiles, EveryRowIsOnTheObjectPageAndInTheEds) {
  for (const auto& variant : kVariants) {
    const std::string page = object_reference(variant.variant);
    const std::string eds = esi::write_eds(device_description(variant.variant), "drive.eds");
    const auto rows = dictionary_table(variant.variant).rows();
    EXPECT_EQ(static_cast<std::size_t>(std::count(page.begin(), page.end(), '\n')), rows.size() + 7);
    std::size_t entries = 0;
    for (auto at = eds.find("AccessType="); at != std::string::npos; at = eds.find("AccessType=", at + 1)) ++entries;
    EXPECT_EQ(entries, rows.size());
  }
}

TEST(GeneratedDeviceFiles, EsiFileReadsBackWithIdentityAndPdos) {
  const auto file = must(esi::read_esi(content("moog_msd.xml"), "moog_msd.xml"));
  const auto* device = file->find_device(kVendorId, kProductCode, kRevision);
  ASSERT_NE(device, nullptr);
  EXPECT_EQ(device->rx_pdos.size(), 4U);
  EXPECT_EQ(device->tx_pdos.size(), 4U);
}

}  // namespace
}  // namespace driveline::slaves::msd
