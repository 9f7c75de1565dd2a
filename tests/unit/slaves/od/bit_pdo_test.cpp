// Process data smaller than a byte, across byte borders, with gaps, and of several sync managers per direction.
#include <gtest/gtest.h>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/pdo/pdo_map.hpp"
#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

using esi::DataType;
using wire::SdoAbort;

EntryRow fixed(std::uint16_t index, std::uint8_t subindex, DataType type, double value) {
  return {
      .index = index, .subindex = subindex, .type = type, .slot = slot::kConstant, .name = "Fixed", .initial = value};
}

/// Two output sync managers (0 and 2) and one input sync manager (5), all fixed, and one writable mapping.
const DictionaryTable& bit_table() {
  static const auto kRows = [] {
    const auto value = [](std::uint16_t index, DataType type) {
      return EntryRow{.index = index, .type = type, .access = kBoth, .name = "Value"};
    };
    std::vector<EntryRow> rows = {value(0x7000, DataType::kBoolean), value(0x7001, DataType::kBit3),
                                  value(0x7002, DataType::kInteger16), value(0x7003, DataType::kUnsigned64),
                                  value(0x7005, DataType::kReal64)};
    rows.push_back(
        {.index = 0x7004, .type = DataType::kOctetString, .access = kBoth, .name = "Raw", .string_length = 3});
    const auto object = [&rows](std::uint16_t index, DataType type, std::vector<double> values) {
      rows.push_back(fixed(index, 0, DataType::kUnsigned8, static_cast<double>(values.size())));
      for (std::size_t i = 0; i < values.size(); ++i) {
        rows.push_back(fixed(index, static_cast<std::uint8_t>(i + 1), type, values[i]));
      }
    };
    object(0x1600, DataType::kUnsigned32, {0x70000001, 0x70010003, 0x00000002, 0x70020010});  // 1 + 3 + gap 2 + 16 bit
    object(0x1610, DataType::kUnsigned32, {0x70040018, 0x70030040});
    object(0x1A00, DataType::kUnsigned32, {0x70010003, 0x70040018, 0x70030040, 0x70020010, 0x70050040});
    object(0x1C10, DataType::kUnsigned16, {0x1600});
    object(0x1C12, DataType::kUnsigned16, {0x1610});
    object(0x1C15, DataType::kUnsigned16, {0x1A00});
    for (std::uint8_t sub = 0; sub <= 3; ++sub) {
      rows.push_back({.index = 0x1601,
                      .subindex = sub,
                      .type = sub == 0 ? DataType::kUnsigned8 : DataType::kUnsigned32,
                      .access = access::kReadWrite,
                      .name = "Mapping"});
    }
    return rows;
  }();
  static const DictionaryTable kTable({kRows}, 0);
  return kTable;
}

constexpr PdoLimits kLimits{.pdos = 512,
                            .objects = 255,
                            .bytes = 1486,
                            .output_sync_managers = 0b101,
                            .input_sync_managers = 0b100000,
                            .gaps = true};

class BitPdo : public testing::Test {
 protected:
  PdoMap built(std::size_t sync_manager) {
    PdoMap map;
    map.build(dictionary, sync_manager, kLimits);
    return map;
  }
  std::uint64_t value(std::uint16_t index) const { return dictionary.raw(*bit_table().find(index, 0)); }
  void set(std::uint16_t index, std::uint64_t raw) { dictionary.set_raw(bit_table().find(index, 0)->slot, raw); }

  ObjectDictionary dictionary{bit_table()};
};

TEST_F(BitPdo, SizesAreWholeBytesOfEachSyncManager) {
  EXPECT_EQ(built(0).size(), 3U);  // 22 bits
  EXPECT_EQ(built(2).size(), 11U);
  EXPECT_EQ(built(5).size(), 22U);  // 171 bits
  EXPECT_EQ(built(3).size(), 0U);
}

TEST_F(BitPdo, DecodesBelowAByteAndAcrossByteBorders) {
  // bit 0: 1, bits 1-3: 0b110, gap 0b11, bits 6-21: -2
  built(0).decode(bytes({0b10'11'110'1, 0b1111'1111, 0b00'111111}), dictionary);
  EXPECT_EQ(value(0x7000), 1U);
  EXPECT_EQ(value(0x7001), 6U);
  EXPECT_EQ(value(0x7002), static_cast<std::uint64_t>(-2));
}

TEST_F(BitPdo, DecodesNumbersOf64BitsAndRawBytes) {
  built(2).decode(bytes({0xA, 0xB, 0, 1, 2, 3, 4, 5, 6, 7, 8}), dictionary);
  EXPECT_EQ(dictionary.text(bit_table().find(0x7004, 0)->slot), std::string("\x0A\x0B\0", 3));
  EXPECT_EQ(value(0x7003), 0x0807060504030201U);
}

TEST_F(BitPdo, EncodesEverythingBehindThreeBits) {
  set(0x7001, 5);
  dictionary.text(bit_table().find(0x7004, 0)->slot) = "\x01\xFF\x80";
  set(0x7003, 0xFEDCBA9876543210U);
  set(0x7002, static_cast<std::uint64_t>(-1));
  set(0x7005, raw_from_number(DataType::kReal64, -2.0));
  std::vector<std::byte> data(22);
  const auto map = built(5);
  map.encode(dictionary, data);
  ObjectDictionary other(bit_table());
  map.decode(data, other);
  for (const std::uint16_t index : std::initializer_list<std::uint16_t>{0x7001, 0x7003, 0x7002, 0x7005}) {
    EXPECT_EQ(other.raw(*bit_table().find(index, 0)), value(index)) << std::hex << index;
  }
  EXPECT_EQ(std::vector(data.begin(), data.begin() + 5), bytes({0x0D, 0xF8, 0x07, 0x84, 0x90}));  // by hand
}

TEST_F(BitPdo, AnEntryThatIsNotCompleteIsLeftAlone) {
  set(0x7002, 77);
  built(0).decode(bytes({0xFF, 0xFF}), dictionary);
  EXPECT_EQ(value(0x7002), 77U);
  EXPECT_EQ(value(0x7001), 7U);
}

TEST_F(BitPdo, MoreEntriesThanThereIsRoomForAreLeftOut) {
  PdoMap map(2);
  map.build(dictionary, 5, kLimits);
  EXPECT_EQ(map.fields().size(), 2U);
  EXPECT_EQ(map.size(), 22U) << "the place of all is kept";
}

TEST_F(BitPdo, MappingsTakeBitsAndGaps) {
  SampleOwner owner;
  owner.decide = [this](const EntryRow& row, std::uint64_t raw) {
    return check_pdo_write(dictionary, kLimits, row, raw);
  };
  const auto write = [&](std::uint8_t sub, std::uint32_t raw) -> std::optional<SdoAbort> {
    const auto le = bytes::to_le_bytes(raw);
    const auto done =
        dictionary.download(0x1601, sub, AccessPhase::kConfiguring, std::span(le).first(sub == 0 ? 1 : 4), owner);
    return done ? std::nullopt : std::optional(done.error());
  };
  EXPECT_EQ(write(1, 0x70010003), std::nullopt);
  EXPECT_EQ(write(1, 0x70010004), SdoAbort::kNotMappable);  // a BIT3 has three bits
  EXPECT_EQ(write(2, 0x00000005), std::nullopt);
  EXPECT_EQ(write(3, 0x70000001), std::nullopt);
  EXPECT_EQ(write(0, 3), std::nullopt);
}

TEST_F(BitPdo, RefusesValuesThatDoNotFitTheirBits) {
  SampleOwner owner;
  const auto two = bytes::to_le_bytes<std::uint8_t>(8);
  EXPECT_EQ(dictionary.download(0x7001, 0, AccessPhase::kConfiguring, two, owner).error(), SdoAbort::kValueTooHigh);
  EXPECT_EQ(dictionary.download(0x7000, 0, AccessPhase::kConfiguring, two, owner).error(), SdoAbort::kValueTooHigh);
}

}  // namespace
}  // namespace driveline::slaves
