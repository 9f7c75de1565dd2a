#include "driveline/slaves/pdo/pdo_map.hpp"

#include <gmock/gmock.h>

#include "driveline/bytes/endian.hpp"
#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

class PdoMapTest : public testing::Test {
 protected:
  PdoMapTest() {
    owner.decide = [this](const EntryRow& row, std::uint64_t raw) {
      return check_pdo_write(dictionary, limits, row, raw);
    };
  }
  std::optional<SdoAbort> write(std::uint16_t index, unsigned sub, std::uint32_t value) {
    const auto* row = sample_table().find(index, static_cast<std::uint8_t>(sub));
    const auto le = bytes::to_le_bytes(value);
    const auto result = dictionary.download(index, static_cast<std::uint8_t>(sub), AccessPhase::kConfiguring,
                                            std::span(le).first(byte_size(*row)), owner);
    return result ? std::nullopt : std::optional(result.error());
  }
  void map(std::uint16_t pdo, std::vector<std::uint32_t> entries) {
    ASSERT_EQ(write(pdo, 0, 0), std::nullopt);
    for (unsigned i = 0; i < entries.size(); ++i) ASSERT_EQ(write(pdo, i + 1, entries[i]), std::nullopt);
    ASSERT_EQ(write(pdo, 0, static_cast<std::uint32_t>(entries.size())), std::nullopt);
  }
  void assign(std::uint16_t object, std::vector<std::uint32_t> pdos) {
    ASSERT_EQ(write(object, 0, 0), std::nullopt);
    for (unsigned i = 0; i < pdos.size(); ++i) ASSERT_EQ(write(object, i + 1, pdos[i]), std::nullopt);
    ASSERT_EQ(write(object, 0, static_cast<std::uint32_t>(pdos.size())), std::nullopt);
  }

  PdoLimits limits;
  ObjectDictionary dictionary{sample_table()};
  SampleOwner owner;
};

TEST_F(PdoMapTest, EntriesOnlyWhileTheCountIsZero) {
  map(0x1600, {0x20000010});
  EXPECT_EQ(write(0x1600, 1, 0x20010008), SdoAbort::kSubindexCannotBeWritten);
  EXPECT_EQ(write(0x1600, 0, 0), std::nullopt);
  EXPECT_EQ(write(0x1600, 1, 0x20010008), std::nullopt);
}

TEST_F(PdoMapTest, RefusesEntriesThatCannotBeMapped) {
  EXPECT_EQ(write(0x1600, 1, 0x77770010), SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(write(0x1600, 1, 0x20000110), SdoAbort::kSubindexDoesNotExist);
  EXPECT_EQ(write(0x1600, 1, 0x60000010), SdoAbort::kNotMappable);  // the alias has no mapping right
  EXPECT_EQ(write(0x1600, 1, 0x200A0008), SdoAbort::kNotMappable);  // only for TxPDOs
  EXPECT_EQ(write(0x1A00, 1, 0x200A0008), std::nullopt);
  EXPECT_EQ(write(0x1600, 1, 0x20000008), SdoAbort::kNotMappable);  // 16 bit object mapped with 8
  EXPECT_EQ(write(0x1600, 1, 0x20030040), SdoAbort::kNotMappable);  // string
}

TEST_F(PdoMapTest, LimitsBytesAndObjects) {
  map(0x1600, {0x20020020, 0x20090120});  // 8 bytes
  ASSERT_EQ(write(0x1600, 0, 0), std::nullopt);
  ASSERT_EQ(write(0x1600, 3, 0x20010008), std::nullopt);
  EXPECT_EQ(write(0x1600, 0, 3), SdoAbort::kMappingTooLong);  // 9 bytes
  EXPECT_EQ(write(0x1600, 0, 9), SdoAbort::kMappingTooLong);  // 9 objects
  map(0x1601, std::vector<std::uint32_t>(8, 0x20010008));     // 8 objects of 1 byte
}

TEST_F(PdoMapTest, RefusesACountThatCoversAnEmptyEntry) {
  ASSERT_EQ(write(0x1600, 2, 0x20010008), std::nullopt);
  EXPECT_EQ(write(0x1600, 0, 2), SdoAbort::kObjectDoesNotExist);
}

TEST_F(PdoMapTest, ChecksAssignments) {
  EXPECT_EQ(write(0x1C12, 1, 0x1A00), SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(write(0x1C12, 1, 0x1604), SdoAbort::kObjectDoesNotExist);
  EXPECT_EQ(write(0x1C13, 1, 0x1600), SdoAbort::kObjectDoesNotExist);
  ASSERT_EQ(write(0x1C12, 1, 0x1600), std::nullopt);
  ASSERT_EQ(write(0x1C12, 2, 0x1600), std::nullopt);
  EXPECT_EQ(write(0x1C12, 0, 2), SdoAbort::kParameterIncompatible);  // the same PDO twice
  EXPECT_EQ(write(0x1C12, 0, 5), SdoAbort::kValueTooHigh);
  EXPECT_EQ(write(0x1C12, 0, 1), std::nullopt);
  EXPECT_EQ(write(0x1C12, 1, 0x1601), SdoAbort::kSubindexCannotBeWritten);
}

TEST_F(PdoMapTest, DecodesInTheOrderOfAssignmentAndSignExtends) {
  map(0x1601, {0x20010008, 0x20000010});
  map(0x1600, {0x20020020});
  assign(0x1C12, {0x1601, 0x1600});
  PdoMap rx;
  rx.build(dictionary, 2, limits);
  ASSERT_EQ(rx.size(), 7U);
  rx.decode(bytes({0x80, 0x34, 0x92, 0xFE, 0xFF, 0xFF, 0xFF}), dictionary);
  EXPECT_EQ(static_cast<std::int64_t>(dictionary.raw(*sample_table().find(0x2001, 0))), -128);
  EXPECT_EQ(dictionary.raw(kSample.shared.number), 0x9234U);  // unsigned: no sign extension
  EXPECT_EQ(static_cast<std::int64_t>(dictionary.raw(*sample_table().find(0x2002, 0))), -2);
}

TEST_F(PdoMapTest, EncodesConstantsAndValues) {
  map(0x1A03, {0x200A0008, 0x20000010, 0x20090220});
  assign(0x1C13, {0x1A03});
  dictionary.set(kSample.shared, std::uint16_t{0xBEEF});
  dictionary.set_raw(sample_table().find(0x2009, 2)->slot, 0x01020304U);
  PdoMap tx;
  tx.build(dictionary, 3, limits);
  std::vector<std::byte> data(7);
  tx.encode(dictionary, data);
  EXPECT_EQ(data, bytes({0x5A, 0xEF, 0xBE, 4, 3, 2, 1}));
}

TEST_F(PdoMapTest, ShortDataLeavesTheRestAlone) {
  map(0x1600, {0x20000010, 0x20020020});
  assign(0x1C12, {0x1600});
  PdoMap rx;
  rx.build(dictionary, 2, limits);
  rx.decode(bytes({1, 0, 2, 0, 0}), dictionary);  // one byte of the long object is missing
  EXPECT_EQ(dictionary.get(kSample.shared), 1);
  EXPECT_EQ(dictionary.raw(*sample_table().find(0x2002, 0)), 0U);
  std::vector<std::byte> none;
  rx.encode(dictionary, none);  // must not write anywhere
}

TEST_F(PdoMapTest, HoldsFourPdosOfEightObjects) {
  for (std::uint16_t pdo = 0x1600; pdo < 0x1604; ++pdo) map(pdo, std::vector<std::uint32_t>(8, 0x20010008));
  assign(0x1C12, {0x1600, 0x1601, 0x1602, 0x1603});
  PdoMap rx;
  rx.build(dictionary, 2, limits);
  EXPECT_EQ(rx.size(), 32U);
}

TEST_F(PdoMapTest, UnassignedMappingsHaveNoProcessData) {
  map(0x1600, {0x20000010});
  PdoMap rx;
  rx.build(dictionary, 2, limits);
  EXPECT_EQ(rx.size(), 0U);
}

}  // namespace
}  // namespace driveline::slaves
