#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/esi/sii.hpp"
#include "sample_device.hpp"
#include "support/must.hpp"

namespace driveline::esi {
namespace {

using test::bytes_of;
using test::random_device;
using test::sample_device;
using test::sii_part;

TEST(MakeSii, FixedWordsLieWhereTheStandardHasThem) {
  const auto bytes = encode_sii(make_sii(sample_device()));
  ASSERT_EQ(bytes.size(), 4096U);
  const auto at = [&](std::size_t word, std::size_t size) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(2 * word);
    return std::vector<std::byte>(begin, begin + static_cast<std::ptrdiff_t>(size));
  };
  EXPECT_EQ(at(0x00, 14), bytes_of("05060344640000000000000A0000"));
  EXPECT_EQ(at(0x08, 16), bytes_of("CDAB0000 34124000 02000100 67120000"));
  EXPECT_EQ(at(0x14, 8), bytes_of("0010 0001 0012 8000"));
  EXPECT_EQ(at(0x18, 8), bytes_of("0018 0002 001C 0002"));
  EXPECT_EQ(at(0x1C, 2), bytes_of("0E00"));
  EXPECT_EQ(at(0x3E, 4), bytes_of("1F00 0100"));
  EXPECT_EQ(at(0x40, 2), bytes_of("0A00"));  // strings first
}

TEST(MakeSii, ChecksumIsValid) {
  EXPECT_TRUE(make_sii(sample_device()).checksum_valid());
  EXPECT_EQ(make_sii(sample_device()).checksum >> 8, 0);
}

TEST(MakeSii, CategoriesFollowEachOtherAsInRealImages) {
  std::vector<unsigned> types;
  for (const auto& category : make_sii(sample_device()).categories)
    types.push_back(static_cast<unsigned>(category.type));
  EXPECT_THAT(types, ::testing::ElementsAre(10, 30, 40, 41, 50, 51, 60));
}

TEST(MakeSii, EqualTextsAreStoredOnce) {
  DeviceDescription device;
  device.type = device.name = device.group_type = "same";
  const auto image = make_sii(device);
  EXPECT_EQ(image.find<SiiStrings>(SiiCategoryType::kStrings)->texts, std::vector<std::string>{"same"});
}

TEST(MakeSii, EepromGrowsUntilTheContentFits) {
  DeviceDescription device = sample_device();
  device.eeprom_bytes = 128;
  const auto image = make_sii(device);
  EXPECT_EQ(image.image_bytes, image.eeprom_bytes());
  EXPECT_EQ(encode_sii(image).size(), image.eeprom_bytes());
  EXPECT_EQ(image.eeprom_bytes(), 512U);
  ASSERT_TRUE(decode_sii(encode_sii(image)));
}

TEST(MakeSii, WhatTheFormatCannotHoldIsCut) {
  DeviceDescription device;
  device.name = std::string(300, 'n');
  Pdo pdo;
  for (int i = 0; i < 300; ++i)
    pdo.entries.push_back({0x2000, 1, 8, std::string("e").append(std::to_string(i)), DataType::kUnsigned8});
  device.rx_pdos = {pdo};
  const auto decoded = must(decode_sii(encode_sii(make_sii(device))));
  const auto back = description_from_sii(*decoded);
  EXPECT_EQ(back.name, std::string(255, 'n'));
  ASSERT_EQ(back.rx_pdos.at(0).entries.size(), 255U);
  EXPECT_EQ(back.rx_pdos[0].entries[253].name, "e253");
  EXPECT_EQ(back.rx_pdos[0].entries[254].name, "");  // text number 256
}

TEST(DescriptionFromSii, GivesBackWhatTheImageHolds) {
  const auto image = must(decode_sii(encode_sii(make_sii(sample_device()))));
  EXPECT_EQ(description_from_sii(*image), sii_part(sample_device()));
}

TEST(DescriptionFromSii, RandomDevices) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const DeviceDescription device = random_device(random);
    const SiiImage made = make_sii(device);
    const auto bytes = encode_sii(made);
    const auto image = must(decode_sii(bytes));
    ASSERT_EQ(encode_sii(*image), bytes);
    DeviceDescription expected = sii_part(device);
    expected.eeprom_bytes = static_cast<std::uint32_t>(made.eeprom_bytes());
    ASSERT_EQ(description_from_sii(*image), expected);
  }
}

TEST(DescriptionFromSii, PdosOfSeveralCategories) {
  SiiImage image = make_sii(sample_device());
  image.categories.push_back({SiiCategoryType::kRxPdo, std::vector<SiiPdo>{{0x16FF, 0xFF, 0, 0, 0, {}}}});
  EXPECT_EQ(description_from_sii(image).rx_pdos.size(), 3U);
  EXPECT_EQ(description_from_sii(image).rx_pdos.back().index, 0x16FF);
}

TEST(DescriptionFromSii, ImageWithoutCategories) {
  SiiImage image;
  image.vendor_id = 5;
  const auto device = description_from_sii(image);
  EXPECT_EQ(device.vendor_id, 5U);
  EXPECT_EQ(device.name, "");
  EXPECT_TRUE(device.sync_managers.empty());
}

TEST(DescriptionFromSii, UnknownUsesAreUnused) {
  SiiImage image;
  image.categories = {{SiiCategoryType::kFmmu, SiiFmmus{{0xFF, 9, 2, 0xFF}}},
                      {SiiCategoryType::kSyncManager, std::vector<SiiSyncManager>{{0x1000, 1, 2, 0, 1, 77}}}};
  const auto device = description_from_sii(image);
  EXPECT_THAT(device.fmmus, ::testing::ElementsAre(FmmuUse::kUnused, FmmuUse::kUnused, FmmuUse::kInputs));
  EXPECT_EQ(device.sync_managers.at(0).use, SyncManager::Use::kUnused);
}

}  // namespace
}  // namespace driveline::esi
