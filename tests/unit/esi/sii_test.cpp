#include "driveline/esi/sii.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sample_device.hpp"

namespace driveline::esi {
namespace {

using test::bytes_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The 64 fixed words, typed by hand from ETG.1000.6 5.4: every field has a distinct value.
constexpr std::string_view kHeader =
    "0506 0344 6400 0100 3412 0000 0000 0000"  // PDI, sync impulse 1 us, alias 0x1234, reserved, checksum (not valid)
    "CDAB0000 34124000 02000100 67120000"      // vendor, product, revision, serial number
    "1000 2000 3000 4000"                      // delays
    "0010 0001 0012 8000"                      // bootstrap mailbox
    "0018 0002 001C 0004"                      // standard mailbox
    "0E00"                                     // EoE, CoE, FoE
    "000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "000000000000000000000000"
    "0F00 0100";  // 16 KiBit, version 1

std::vector<std::byte> image_of(std::string_view categories, std::string_view end = "FFFF") {
  auto image = bytes_of(kHeader);
  for (const auto part : {categories, end}) {
    const auto bytes = bytes_of(part);
    image.insert(image.end(), bytes.begin(), bytes.end());
  }
  return image;
}

template <std::size_t N>
std::array<std::byte, N> array_of(std::string_view hex) {
  const auto bytes = bytes_of(hex);
  std::array<std::byte, N> array{};
  for (std::size_t i = 0; i < N; ++i) array[i] = bytes[i];
  return array;
}

SiiError error_of(std::string_view categories, std::string_view end = "FFFF") {
  const auto image = decode_sii(image_of(categories, end));
  return image ? SiiError{} : image.error();
}

TEST(SiiChecksum, IsTheOneOfRealDevices) {
  // Bytes 0-13 of the EEPROM of an AKD drive, an EK1100 coupler and an EL2004 terminal, each followed by its byte 14.
  EXPECT_EQ(sii_checksum(array_of<14>("09000008000000000000 00000000")), 0x10);
  EXPECT_EQ(sii_checksum(array_of<14>("000D000000000000000000000000")), 0x46);
  EXPECT_EQ(sii_checksum(array_of<14>("0401000000000F00000000000000")), 0xD8);
}

TEST(SiiChecksum, IsAFactOfTheImageAndNoDecodeError) {
  auto image = decode_sii(image_of("")).value();
  EXPECT_FALSE(image.checksum_valid());
  image.checksum = sii_checksum(image.config.bytes());
  EXPECT_TRUE(image.checksum_valid());
  image.config.station_alias ^= 1;
  EXPECT_FALSE(image.checksum_valid());
  image.checksum = 0x88A4;  // check switched off
  EXPECT_TRUE(image.checksum_valid());
}

TEST(SiiDecode, FixedWords) {
  ASSERT_EQ(bytes_of(kHeader).size(), 128U);
  const auto image = decode_sii(image_of("")).value();
  EXPECT_EQ(image.config.pdi_control, 0x0605);
  EXPECT_EQ(image.config.pdi_configuration, 0x4403);
  EXPECT_EQ(image.config.sync_impulse_10ns, 100);
  EXPECT_EQ(image.config.pdi_configuration2, 1);
  EXPECT_EQ(image.config.station_alias, 0x1234);
  EXPECT_EQ(image.vendor_id, 0x0000ABCDU);
  EXPECT_EQ(image.product_code, 0x00401234U);
  EXPECT_EQ(image.revision, 0x00010002U);
  EXPECT_EQ(image.serial_number, 4711U);
  EXPECT_THAT(image.delays, ElementsAre(0x10, 0x20, 0x30, 0x40));
  EXPECT_EQ(image.bootstrap_mailbox, (SiiMailboxWindow{0x1000, 0x100, 0x1200, 0x80}));
  EXPECT_EQ(image.standard_mailbox, (SiiMailboxWindow{0x1800, 0x200, 0x1C00, 0x400}));
  EXPECT_EQ(image.mailbox_protocols, sii_mailbox::kEoe | sii_mailbox::kCoe | sii_mailbox::kFoe);
  EXPECT_EQ(image.eeprom_bytes(), 2048U);
  EXPECT_EQ(image.version, 1);
  EXPECT_TRUE(image.categories.empty());
}

TEST(SiiDecode, Strings) {
  const auto image = decode_sii(image_of("0A00 0400 02 02 4142 03 63 64 65")).value();  // one byte is missing
  const auto* strings = image.find<SiiStrings>(SiiCategoryType::kStrings);
  ASSERT_NE(strings, nullptr);
  EXPECT_THAT(strings->texts, ElementsAre("AB", "cde"));
  EXPECT_EQ(image.text(1), "AB");
  EXPECT_EQ(image.text(2), "cde");
  EXPECT_EQ(image.text(0), "");
  EXPECT_EQ(image.text(3), "");
  EXPECT_EQ(image.text(255), "");
}

TEST(SiiDecode, General) {
  // Category 30 of an EL2004 terminal (ports: two E-bus, 100 mA).
  const auto image =
      decode_sii(image_of("1E00 1000 02 00 01 04 0C 00 00 00 00 00 00 00 6400 03 00 3300 0000000000000000000000000000"))
          .value();
  const auto* general = image.find<SiiGeneral>(SiiCategoryType::kGeneral);
  ASSERT_NE(general, nullptr);
  EXPECT_EQ(general->group_text, 2);
  EXPECT_EQ(general->image_text, 0);
  EXPECT_EQ(general->order_text, 1);
  EXPECT_EQ(general->name_text, 4);
  EXPECT_EQ(general->ebus_current_ma, 100);
  EXPECT_EQ(general->group_name_text, 3);
  EXPECT_EQ(general->physical_ports, 0x0033);
  EXPECT_EQ(general->further.size(), SiiGeneral::kFurtherSize);
}

TEST(SiiDecode, Identification) {
  // The same category with bits of ETG.1000.6 Table 22 in its flags: bit 3 is the AL status code, bit 4 another place.
  const auto announced = [](std::string_view flags) {
    const auto category = "1E00 1000 02 00 01 04 0C 00 00 00 00 00 00 " + std::string(flags) +
                          " 6400 03 00 3300 0000000000000000000000000000";
    return description_from_sii(decode_sii(image_of(category)).value()).identification;
  };
  EXPECT_FALSE(announced("00"));
  EXPECT_TRUE(announced("08"));
  EXPECT_FALSE(announced("17"));
}

TEST(SiiDecode, FmmusAndSyncManagers) {
  // Categories 40 and 41 of an AKD drive (the first two sync managers).
  const auto image = decode_sii(image_of("2800 0200 010203FF 2900 0800 00180004 26000101 001C0004 22000102")).value();
  EXPECT_THAT(image.find<SiiFmmus>(SiiCategoryType::kFmmu)->uses, ElementsAre(1, 2, 3, 0xFF));
  const auto* sms = image.find<std::vector<SiiSyncManager>>(SiiCategoryType::kSyncManager);
  ASSERT_NE(sms, nullptr);
  EXPECT_THAT(*sms,
              ElementsAre(SiiSyncManager{0x1800, 0x400, 0x26, 0, 1, 1}, SiiSyncManager{0x1C00, 0x400, 0x22, 0, 1, 2}));
}

TEST(SiiDecode, Pdos) {
  // The first PDOs of category 51 of an AKD drive and of an EL2004 terminal, as TxPDO and RxPDO.
  const auto image =
      decode_sii(
          image_of("3200 0800 001601FF 00170000 40600018 06100000 3300 0800 00160100 00051100 00700106 01010000"))
          .value();
  const auto* tx = image.find<std::vector<SiiPdo>>(SiiCategoryType::kTxPdo);
  const auto* rx = image.find<std::vector<SiiPdo>>(SiiCategoryType::kRxPdo);
  ASSERT_NE(tx, nullptr);
  ASSERT_NE(rx, nullptr);
  EXPECT_THAT(*tx, ElementsAre(SiiPdo{0x1600, 0xFF, 0, 0x17, 0, {{0x6040, 0, 0x18, 6, 16, 0}}}));
  EXPECT_THAT(*rx, ElementsAre(SiiPdo{0x1600, 0, 0, 5, 0x0011, {{0x7000, 1, 6, 1, 1, 0}}}));
}

TEST(SiiDecode, DistributedClock) {
  // Category 60 of an AKD drive, first mode; then one with a value in each field.
  const auto image = decode_sii(image_of("3C00 1800 00000000 00000000 00000000 0000 0003 0100 06 00 00000000"
                                         "48E80100 18FCFFFF 20030000 FEFF 0007 0200 01 02 AABBCCDD"))
                         .value();
  const auto* modes = image.find<std::vector<SiiDcMode>>(SiiCategoryType::kDistributedClock);
  ASSERT_NE(modes, nullptr);
  ASSERT_EQ(modes->size(), 2U);
  EXPECT_EQ((*modes)[0], (SiiDcMode{0, 0, 0, 0, 0x0300, 1, 6, 0, {}}));
  EXPECT_EQ((*modes)[1], (SiiDcMode{125000, 0xFFFFFC18, 800, -2, 0x0700, 2, 1, 2, array_of<4>("AABBCCDD")}));
}

TEST(SiiDecode, UnknownCategoriesAreKeptInOrder) {
  const auto bytes = image_of("0108 0100 1234  1400 0000  2B00 0100 F0FF  0108 0200 01020304");
  const auto image = decode_sii(bytes).value();
  ASSERT_EQ(image.categories.size(), 4U);
  EXPECT_EQ(image.categories[0].type, static_cast<SiiCategoryType>(0x0801));
  EXPECT_EQ(image.categories[1].type, SiiCategoryType::kDataTypes);
  EXPECT_EQ(image.categories[2].type, SiiCategoryType::kSyncUnit);
  EXPECT_EQ(image.categories[3], (SiiCategory{static_cast<SiiCategoryType>(0x0801), SiiRaw{bytes_of("01020304")}}));
  EXPECT_EQ(encode_sii(image), bytes);
}

TEST(SiiDecode, WhatFollowsTheEndIsKept) {
  const auto bytes = image_of("", "FFFF 0000 FFFF 1234 FFFF FFFF");
  const auto image = decode_sii(bytes).value();
  EXPECT_EQ(image.tail, bytes_of("0000FFFF1234"));
  EXPECT_EQ(image.image_bytes, bytes.size());
  EXPECT_EQ(encode_sii(image), bytes);
}

TEST(SiiDecode, ErasedEeprom) {
  const std::vector<std::byte> erased(2048, std::byte{0xFF});
  const auto image = decode_sii(erased).value();
  EXPECT_EQ(image.vendor_id, 0xFFFFFFFFU);
  EXPECT_FALSE(image.checksum_valid());
  EXPECT_EQ(encode_sii(image), erased);
}

TEST(SiiErrors, SizeOfTheImage) {
  auto bytes = image_of("");
  bytes.push_back(std::byte{0xFF});
  EXPECT_EQ(decode_sii(bytes).error().code, SiiErrorCode::kOddSize);
  EXPECT_EQ(decode_sii({}).error(), (SiiError{SiiErrorCode::kNoHeader, SiiCategoryType::kEnd, 0, 128, 0}));
  bytes.resize(126);
  EXPECT_EQ(decode_sii(bytes).error(), (SiiError{SiiErrorCode::kNoHeader, SiiCategoryType::kEnd, 0, 128, 126}));
  EXPECT_EQ(error_of("", ""), (SiiError{SiiErrorCode::kNoEnd, SiiCategoryType::kEnd, 0x40, 2, 0}));
  EXPECT_EQ(error_of("2800 0000", ""), (SiiError{SiiErrorCode::kNoEnd, SiiCategoryType::kEnd, 0x42, 2, 0}));
}

TEST(SiiErrors, LengthOfACategory) {
  EXPECT_EQ(error_of("2800", ""), (SiiError{SiiErrorCode::kLongCategory, SiiCategoryType::kFmmu, 0x41, 2, 0}));
  EXPECT_EQ(error_of("2800 0300 0102", "FFFF"),
            (SiiError{SiiErrorCode::kLongCategory, SiiCategoryType::kFmmu, 0x42, 6, 4}));
  EXPECT_EQ(error_of("2800 FFFF 0102").needed_bytes, 131070U);
}

TEST(SiiErrors, ElementsOfACategory) {
  using C = SiiCategoryType;
  using E = SiiErrorCode;
  EXPECT_EQ(error_of("0A00 0000"), (SiiError{E::kBadSize, C::kStrings, 0x42, 1, 0}));
  EXPECT_EQ(error_of("0A00 0200 02 02 4142"), (SiiError{E::kLongText, C::kStrings, 0x44, 1, 0}));
  EXPECT_EQ(error_of("0A00 0200 01 03 4142"), (SiiError{E::kLongText, C::kStrings, 0x43, 3, 2}));
  EXPECT_EQ(error_of("1E00 0800 00000000000000000000000000000000"), (SiiError{E::kBadSize, C::kGeneral, 0x42, 18, 16}));
  EXPECT_EQ(error_of("2900 0500 0018000426000101 0018"), (SiiError{E::kBadSize, C::kSyncManager, 0x46, 8, 2}));
  EXPECT_EQ(error_of("3200 0300 001A00FF0008"), (SiiError{E::kBadSize, C::kTxPdo, 0x42, 8, 6}));
  EXPECT_EQ(error_of("3300 0800 001602FF00080000 4160000906100000"),
            (SiiError{E::kLongEntryList, C::kRxPdo, 0x46, 16, 8}));
  EXPECT_EQ(error_of("3C00 0100 0000"), (SiiError{E::kBadSize, C::kDistributedClock, 0x42, 24, 2}));
}

TEST(SiiErrors, AreSentencesWithThePlace) {
  const std::string text = to_text(error_of("3300 0800 001602FF00080000 4160000906100000"));
  EXPECT_EQ(
      text,
      "SII word 0x0046, category 51: a PDO has more entries than its category contains (16 bytes needed, 8 there)");
  EXPECT_THAT(to_text(decode_sii({}).error()), HasSubstr("shorter than the fixed area"));
  EXPECT_THAT(to_text(error_of("", "")), HasSubstr("word 0x0040"));
}

TEST(SiiEncode, OddContentIsFilledToAWholeWord) {
  SiiImage image = decode_sii(image_of("")).value();
  image.categories = {{SiiCategoryType::kFmmu, SiiFmmus{{1, 2, 3}}},
                      {SiiCategoryType::kStrings, SiiStrings{{"ab"}, {}}}};
  image.image_bytes = 0;
  const auto bytes = encode_sii(image);
  EXPECT_EQ(bytes, image_of("2800 0200 010203FF 0A00 0200 01026162"));
}

TEST(SiiEncode, IsAsLongAsTheImage) {
  SiiImage image = decode_sii(image_of("")).value();
  image.image_bytes = 512;
  const auto bytes = encode_sii(image);
  ASSERT_EQ(bytes.size(), 512U);
  for (std::size_t i = 128; i < bytes.size(); ++i) EXPECT_EQ(bytes[i], std::byte{0xFF}) << i;
}

}  // namespace
}  // namespace driveline::esi
