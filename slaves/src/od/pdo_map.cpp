#include "driveline/slaves/od/pdo_map.hpp"

#include <algorithm>

#include "driveline/wire/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

constexpr std::uint16_t kRxAssignment = 0x1C12;
constexpr std::uint16_t kTxAssignment = 0x1C13;

/// A mapping entry: index, sub-index and length in bits, as stored in 1600h and 1A00h.
struct MappingEntry {
  std::uint16_t index;
  std::uint8_t subindex;
  std::uint8_t bits;
  explicit constexpr MappingEntry(std::uint32_t raw) noexcept
      : index(static_cast<std::uint16_t>(raw >> 16)),
        subindex(static_cast<std::uint8_t>(raw >> 8)),
        bits(static_cast<std::uint8_t>(raw)) {}
};

std::uint32_t value_of(const ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t subindex) noexcept {
  const auto* row = dictionary.table().find(index, subindex);
  return row == nullptr ? 0 : dictionary.raw(*row);
}

bool in_block(std::uint16_t index, std::uint16_t first, std::uint8_t count) noexcept {
  return index >= first && index < first + count;
}

SdoResult<void> check_mapping_entry(const ObjectDictionary& dictionary, std::uint16_t mappable, std::uint32_t raw) {
  if (raw == 0) return {};  // clears the entry
  const MappingEntry entry(raw);
  if (dictionary.table().object(entry.index).empty()) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  const auto* row = dictionary.table().find(entry.index, entry.subindex);
  if (row == nullptr) return tl::unexpected(SdoAbort::kSubindexDoesNotExist);
  if ((row->access & mappable) == 0 || entry.bits != 8 * byte_size(*row)) {
    return tl::unexpected(SdoAbort::kNotMappable);
  }
  return {};
}

SdoResult<void> check_mapping_count(const ObjectDictionary& dictionary, const PdoLimits& limits, std::uint16_t index,
                                    std::uint16_t mappable, std::uint32_t count) {
  if (count > limits.objects) return tl::unexpected(SdoAbort::kMappingTooLong);
  unsigned bits = 0;
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    const std::uint32_t raw = value_of(dictionary, index, static_cast<std::uint8_t>(sub));
    if (raw == 0) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
    const auto valid = check_mapping_entry(dictionary, mappable, raw);
    if (!valid) return valid;
    bits += MappingEntry(raw).bits;
  }
  if (bits > 8U * limits.bytes) return tl::unexpected(SdoAbort::kMappingTooLong);
  return {};
}

SdoResult<void> check_assignment_count(const ObjectDictionary& dictionary, std::uint16_t index, std::uint16_t first,
                                       const PdoLimits& limits, std::uint32_t count) {
  if (count > limits.pdos) return tl::unexpected(SdoAbort::kValueTooHigh);
  std::uint32_t seen = 0;
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    const auto pdo = value_of(dictionary, index, static_cast<std::uint8_t>(sub));
    if (!in_block(static_cast<std::uint16_t>(pdo), first, limits.pdos)) {
      return tl::unexpected(SdoAbort::kObjectDoesNotExist);
    }
    const std::uint32_t bit = 1U << (pdo - first);
    if ((seen & bit) != 0) return tl::unexpected(SdoAbort::kParameterIncompatible);
    seen |= bit;
  }
  return {};
}

}  // namespace

SdoResult<void> check_pdo_write(const ObjectDictionary& dictionary, const PdoLimits& limits, const EntryRow& row,
                                std::uint32_t raw) {
  const bool rx_mapping = in_block(row.index, limits.rx_first, limits.pdos);
  const bool tx_mapping = in_block(row.index, limits.tx_first, limits.pdos);
  const bool assignment = row.index == kRxAssignment || row.index == kTxAssignment;
  if (!rx_mapping && !tx_mapping && !assignment) return {};
  const std::uint16_t mappable = rx_mapping ? access::kRxMappable : access::kTxMappable;
  const std::uint16_t first = row.index == kRxAssignment ? limits.rx_first : limits.tx_first;
  if (row.subindex == 0) {
    return assignment ? check_assignment_count(dictionary, row.index, first, limits, raw)
                      : check_mapping_count(dictionary, limits, row.index, mappable, raw);
  }
  if (value_of(dictionary, row.index, 0) != 0) return tl::unexpected(SdoAbort::kSubindexCannotBeWritten);
  if (!assignment) return check_mapping_entry(dictionary, mappable, raw);
  if (raw != 0 && !in_block(static_cast<std::uint16_t>(raw), first, limits.pdos)) {
    return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  }
  return {};
}

void PdoMap::append(const ObjectDictionary& dictionary, std::uint32_t entry) noexcept {
  const MappingEntry mapping(entry);
  const auto* row = dictionary.table().find(mapping.index, mapping.subindex);
  if (row == nullptr || count_ == kMaxFields) return;
  const auto bytes = static_cast<std::uint8_t>(mapping.bits / 8);
  const bool constant = row->slot == slot::kConstant;
  fields_[count_++] = {row->slot, static_cast<std::uint16_t>(size_),  bytes, is_signed(row->type),
                       constant,  constant ? dictionary.raw(*row) : 0};
  size_ += bytes;
}

void PdoMap::build(const ObjectDictionary& dictionary, PdoDirection direction, const PdoLimits& limits) noexcept {
  count_ = 0;
  size_ = 0;
  const std::uint16_t assignment = direction == PdoDirection::kRx ? kRxAssignment : kTxAssignment;
  const std::uint32_t pdos = value_of(dictionary, assignment, 0);
  for (std::uint32_t i = 1; i <= std::min<std::uint32_t>(pdos, limits.pdos); ++i) {
    const auto pdo = static_cast<std::uint16_t>(value_of(dictionary, assignment, static_cast<std::uint8_t>(i)));
    const std::uint32_t objects = value_of(dictionary, pdo, 0);
    for (std::uint32_t sub = 1; sub <= std::min<std::uint32_t>(objects, limits.objects); ++sub) {
      append(dictionary, value_of(dictionary, pdo, static_cast<std::uint8_t>(sub)));
    }
  }
}

void PdoMap::decode(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Field& field = fields_[i];
    if (field.constant || std::size_t{field.offset} + field.bytes > data.size()) continue;
    const auto bytes = data.subspan(field.offset);
    if (field.bytes == 4) {
      dictionary.set(field.slot, wire::load_le<std::uint32_t>(bytes));
    } else if (field.bytes == 2) {
      const auto value = wire::load_le<std::uint16_t>(bytes);
      dictionary.set(field.slot,
                     field.is_signed ? static_cast<std::uint32_t>(static_cast<std::int16_t>(value)) : value);
    } else {
      const auto value = wire::load_le<std::uint8_t>(bytes);
      dictionary.set(field.slot, field.is_signed ? static_cast<std::uint32_t>(static_cast<std::int8_t>(value)) : value);
    }
  }
}

void PdoMap::encode(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Field& field = fields_[i];
    if (std::size_t{field.offset} + field.bytes > data.size()) continue;
    const auto bytes = data.subspan(field.offset);
    const auto value = field.constant ? field.constant_value : dictionary.get<std::uint32_t>(field.slot);
    if (field.bytes == 4) {
      wire::store_le(bytes, value);
    } else if (field.bytes == 2) {
      wire::store_le(bytes, static_cast<std::uint16_t>(value));
    } else {
      wire::store_le(bytes, static_cast<std::uint8_t>(value));
    }
  }
}

}  // namespace driveline::slaves
