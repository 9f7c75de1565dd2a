#pragma once

#include <array>
#include <functional>
#include <vector>

#include "driveline/slaves/od/object_dictionary.hpp"

namespace driveline::slaves {

/// A small device for the tests of dictionary and PDO mapping, independent of any drive.
struct SampleValues : SlotNumbers {
  constexpr SampleValues() noexcept : SlotNumbers(0) {}
  Slot<std::uint16_t> shared{next()};
  Slot<float> real{next()};
};
inline constexpr SampleValues kSample{};

inline constexpr std::uint16_t kBoth = access::kReadWrite | access::kRxMappable | access::kTxMappable;

inline const DictionaryTable& sample_table() {
  using esi::DataType;
  using esi::ObjectCode;
  static const auto kRows = [] {
    std::vector<EntryRow> list = {
        {.index = 0x2000,
         .type = DataType::kUnsigned16,
         .access = kBoth,
         .slot = kSample.shared.number,
         .name = "Shared"},
        {.index = 0x6000,
         .type = DataType::kUnsigned16,
         .access = access::kReadWrite,
         .slot = kSample.shared.number,
         .name = "Alias"},
        {.index = 0x2001,
         .type = DataType::kInteger8,
         .access = kBoth,
         .name = "Small",
         .initial = -3,
         .minimum = -10,
         .maximum = 10},
        {.index = 0x2002, .type = DataType::kInteger32, .access = kBoth, .name = "Long"},
        {.index = 0x2003,
         .type = DataType::kVisibleString,
         .access = access::kReadWrite | access::kBackup,
         .name = "Text",
         .text = "abc",
         .string_length = 8},
        {.index = 0x2004,
         .type = DataType::kReal32,
         .access = access::kReadWrite | access::kBackup,
         .slot = kSample.real.number,
         .name = "Real",
         .initial = 1.5},
        {.index = 0x2005, .type = DataType::kUnsigned8, .access = access::kWrite, .name = "Command"},
        {.index = 0x2006, .type = DataType::kUnsigned8, .access = access::kRead, .name = "Fact", .initial = 7},
        {.index = 0x2007, .type = DataType::kUnsigned8, .access = access::kReadWriteConfiguring, .name = "Setting"},
        {.index = 0x2008,
         .type = DataType::kUnsigned32,
         .access = access::kReadWrite,
         .name = "Locked",
         .power_off_only = true},
        {.index = 0x2009,
         .code = ObjectCode::kArray,
         .type = DataType::kUnsigned8,
         .slot = slot::kConstant,
         .name = "List",
         .initial = 2},
        {.index = 0x2009,
         .subindex = 1,
         .code = ObjectCode::kArray,
         .type = DataType::kUnsigned32,
         .access = kBoth,
         .name = "First"},
        {.index = 0x2009,
         .subindex = 2,
         .code = ObjectCode::kArray,
         .type = DataType::kUnsigned32,
         .access = kBoth,
         .name = "Second"},
        {.index = 0x200A,
         .type = DataType::kUnsigned8,
         .access = access::kRead | access::kTxMappable,
         .slot = slot::kConstant,
         .name = "Constant",
         .initial = 0x5A},
    };
    const auto configuration = [&](std::uint16_t index, ObjectCode code, DataType entry, std::uint8_t entries) {
      EntryRow row{.index = index,
                   .code = code,
                   .type = DataType::kUnsigned8,
                   .access = access::kReadWriteConfiguring,
                   .name = "Configuration"};
      list.push_back(row);
      row.type = entry;
      for (row.subindex = 1; row.subindex <= entries; ++row.subindex) list.push_back(row);
    };
    for (std::uint16_t i = 0; i < 4; ++i) {
      configuration(static_cast<std::uint16_t>(0x1600 + i), ObjectCode::kRecord, DataType::kUnsigned32, 8);
      configuration(static_cast<std::uint16_t>(0x1A00 + i), ObjectCode::kRecord, DataType::kUnsigned32, 8);
    }
    configuration(0x1C12, ObjectCode::kArray, DataType::kUnsigned16, 4);
    configuration(0x1C13, ObjectCode::kArray, DataType::kUnsigned16, 4);
    return list;
  }();
  static const DictionaryTable kTable({kRows}, kSample.end());
  return kTable;
}

inline std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> out;
  for (const unsigned value : values) out.push_back(static_cast<std::byte>(value));
  return out;
}

/// An owner that can refuse, records writes, and has a power stage.
struct SampleOwner : DictionaryOwner {
  std::function<SdoResult<void>(const EntryRow&, std::uint64_t)> decide;
  std::vector<std::pair<std::uint16_t, std::uint8_t>> writes;
  bool power = false;
  SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override {
    return decide ? decide(row, raw) : SdoResult<void>{};
  }
  void written(const EntryRow& row) override { writes.emplace_back(row.index, row.subindex); }
  bool power_stage_on() const noexcept override { return power; }
};

}  // namespace driveline::slaves
