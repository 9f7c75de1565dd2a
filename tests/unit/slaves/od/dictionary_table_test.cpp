#include "driveline/slaves/od/dictionary_table.hpp"

#include <gmock/gmock.h>

#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

using esi::DataType;

TEST(DictionaryTable, FindsObjectsAndSubIndices) {
  const auto& table = sample_table();
  EXPECT_EQ(table.object(0x2009).size(), 3U);
  EXPECT_EQ(table.find(0x2009, 2)->name, "Second");
  EXPECT_EQ(table.find(0x2009, 3), nullptr);
  EXPECT_TRUE(table.object(0x200B).empty());
  EXPECT_TRUE(table.object(0xFFFF).empty());
}

TEST(DictionaryTable, WalksAllObjectsInOrder) {
  std::vector<std::uint16_t> indices;
  const auto& table = sample_table();
  for (auto rows = table.next_object(0); !rows.empty(); rows = table.next_object(rows.front().index)) {
    indices.push_back(rows.front().index);
  }
  EXPECT_EQ(indices.size(), 8U + 2U + 12U);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_EQ(indices.front(), 0x1600);
  EXPECT_EQ(indices.back(), 0x6000);
}

TEST(DictionaryTable, RejectsAnAddressUsedTwice) {
  const std::array rows = {EntryRow{.index = 0x2000}, EntryRow{.index = 0x2000}};
  EXPECT_THROW(DictionaryTable({rows}, 0), std::logic_error);
}

TEST(DictionaryTable, RejectsAliasesThatDisagree) {
  const std::array types = {EntryRow{.index = 0x2000, .type = DataType::kUnsigned8, .slot = 0},
                            EntryRow{.index = 0x2001, .type = DataType::kUnsigned16, .slot = 0}};
  EXPECT_THROW(DictionaryTable({types}, 1), std::logic_error);
  const std::array defaults = {EntryRow{.index = 0x2000, .slot = 0, .initial = 1},
                               EntryRow{.index = 0x2001, .slot = 0, .initial = 2}};
  EXPECT_THROW(DictionaryTable({defaults}, 1), std::logic_error);
}

TEST(DictionaryTable, RejectsSlotsAndTypesItCannotHold) {
  const std::array slots = {EntryRow{.index = 0x2000, .slot = 5}};
  EXPECT_THROW(DictionaryTable({slots}, 5), std::logic_error);
  const std::array types = {EntryRow{.index = 0x2000, .type = DataType{0x0016}}};  // UNSIGNED24, without a length
  EXPECT_THROW(DictionaryTable({types}, 0), std::logic_error);
}

TEST(EntryRow, ConvertsNumbersOfEveryType) {
  EXPECT_EQ(raw_from_number(DataType::kInteger8, -3), 0xFFFFFFFFFFFFFFFDU);
  EXPECT_EQ(raw_from_number(DataType::kUnsigned32, 4294967295.0), 0xFFFFFFFFU);
  EXPECT_EQ(raw_from_number(DataType::kReal32, 1.0), 0x3F800000U);  // IEEE 754
  EXPECT_DOUBLE_EQ(number_from_raw(DataType::kInteger16, 0xFFFFFFFFFFFFFFFEU), -2.0);
  EXPECT_DOUBLE_EQ(number_from_raw(DataType::kUnsigned16, 0xFFFEU), 65534.0);
  EXPECT_DOUBLE_EQ(number_from_raw(DataType::kReal32, 0xC0000000U), -2.0);
  EXPECT_EQ(raw_from_number(DataType::kReal64, 1.0), 0x3FF0000000000000U);  // IEEE 754
  EXPECT_DOUBLE_EQ(number_from_raw(DataType::kReal64, 0xC000000000000000U), -2.0);
  EXPECT_DOUBLE_EQ(number_from_raw(DataType::kInteger64, 0xFFFFFFFFFFFFFFFEU), -2.0);
}

TEST(EntryRow, KeepsA64BitDefaultExactly) {
  using namespace std::string_view_literals;
  EXPECT_EQ(initial_raw({.type = DataType::kUnsigned64, .text = "\xFF\xFE\xFD\xFC\xFB\xFA\xF9\xF8"sv}),
            0xF8F9FAFBFCFDFEFFU);
  EXPECT_EQ(initial_raw({.type = DataType::kUnsigned64, .initial = 7}), 7U);
}

TEST(EntryRow, SizesInBits) {
  EXPECT_EQ(bit_size(EntryRow{.type = DataType::kBoolean}), 1U);
  EXPECT_EQ(bit_size(EntryRow{.type = DataType::kBit3}), 3U);
  EXPECT_EQ(bit_size(EntryRow{.type = DataType::kInteger16}), 16U);
  EXPECT_EQ(bit_size(EntryRow{.type = DataType::kVisibleString, .string_length = 5}), 40U);
  EXPECT_EQ(bit_size(EntryRow{.type = DataType::kOctetString, .string_length = 2, .bit_length = 12}), 12U);
  EXPECT_EQ(byte_size(EntryRow{.type = DataType::kBit3}), 1U);
  EXPECT_EQ(byte_size(EntryRow{.type = DataType::kUnsigned64}), 8U);
}

TEST(EntryRow, NamesTheLengthEntryOfStandardArraysOnly) {
  using esi::ObjectCode;
  EXPECT_EQ(entry_name({.index = 0x6091, .code = ObjectCode::kArray, .name = "Gear ratio"}), "Number of entries");
  EXPECT_EQ(entry_name({.index = 0x217B, .code = ObjectCode::kArray, .name = "CON_IP_FFMode"}), "CON_IP_FFMode");
  EXPECT_EQ(entry_name({.index = 0x6040, .name = "Control word"}), "Control word");
}

}  // namespace
}  // namespace driveline::slaves
