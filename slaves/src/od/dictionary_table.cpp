#include "driveline/slaves/od/dictionary_table.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <stdexcept>
#include <string>

namespace driveline::slaves {
namespace {

constexpr std::uint32_t address(const EntryRow& row) noexcept {
  return (static_cast<std::uint32_t>(row.index) << 8) | row.subindex;
}

[[noreturn]] void reject(const char* what, const EntryRow& row) {
  throw std::logic_error(std::string(what) + " at object " + std::to_string(row.index) + " sub-index " +
                         std::to_string(row.subindex));
}

}  // namespace

std::uint64_t raw_from_number(esi::DataType type, double number) noexcept {
  if (type == esi::DataType::kReal32) return std::bit_cast<std::uint32_t>(static_cast<float>(number));
  if (type == esi::DataType::kReal64) return std::bit_cast<std::uint64_t>(number);
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(number));
}

double number_from_raw(esi::DataType type, std::uint64_t raw) noexcept {
  if (type == esi::DataType::kReal32) {
    return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
  }
  if (type == esi::DataType::kReal64) return std::bit_cast<double>(raw);
  if (is_signed(type)) return static_cast<double>(static_cast<std::int64_t>(raw));
  return static_cast<double>(raw);
}

std::uint64_t initial_raw(const EntryRow& row) noexcept {
  if (row.text.size() != sizeof(std::uint64_t)) return raw_from_number(row.type, row.initial);
  std::uint64_t raw = 0;
  for (std::size_t i = sizeof raw; i-- > 0;) raw = (raw << 8) | static_cast<std::uint8_t>(row.text[i]);
  return raw;
}

DictionaryTable::DictionaryTable(std::initializer_list<std::span<const EntryRow>> parts, std::uint16_t fixed_slots) {
  for (const auto part : parts) rows_.insert(rows_.end(), part.begin(), part.end());
  std::sort(rows_.begin(), rows_.end(), [](const EntryRow& a, const EntryRow& b) { return address(a) < address(b); });
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    if (address(rows_[i - 1]) == address(rows_[i])) reject("two rows", rows_[i]);
  }
  assign_slots(fixed_slots);
}

void DictionaryTable::assign_slots(std::uint16_t fixed_slots) {
  std::vector<const EntryRow*> owner(fixed_slots, nullptr);
  slot_count_ = fixed_slots;
  for (auto& row : rows_) {
    if (is_string(row.type)) {
      const bool text = row.type == esi::DataType::kVisibleString || row.type == esi::DataType::kOctetString;
      if (!text && row.string_length == 0) reject("data type without a length", row);
      if (string_count_ == slot::kConstant) reject("too many texts", row);
      row.slot = string_count_++;
    } else if (row.slot == slot::kOwn) {
      if (slot_count_ == slot::kConstant) reject("too many values", row);
      row.slot = slot_count_++;
    } else if (row.slot != slot::kConstant) {
      if (row.slot >= fixed_slots) reject("slot out of range", row);
      if (owner[row.slot] == nullptr) owner[row.slot] = &row;
      if (owner[row.slot]->type != row.type || std::not_equal_to<>{}(owner[row.slot]->initial, row.initial)) {
        reject("alias of another type or default", row);
      }
    }
  }
}

std::span<const EntryRow> DictionaryTable::object(std::uint16_t index) const noexcept {
  const auto [first, last] = std::equal_range(rows_.begin(), rows_.end(), EntryRow{.index = index},
                                              [](const EntryRow& a, const EntryRow& b) { return a.index < b.index; });
  return {first, last};
}

const EntryRow* DictionaryTable::find(std::uint16_t index, std::uint8_t subindex) const noexcept {
  for (const auto& row : object(index)) {
    if (row.subindex == subindex) return &row;
  }
  return nullptr;
}

std::span<const EntryRow> DictionaryTable::next_object(std::uint16_t index) const noexcept {
  const auto next = std::upper_bound(rows_.begin(), rows_.end(), index,
                                     [](std::uint16_t value, const EntryRow& row) { return value < row.index; });
  return next == rows_.end() ? std::span<const EntryRow>{} : object(next->index);
}

}  // namespace driveline::slaves
