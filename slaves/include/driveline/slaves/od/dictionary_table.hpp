#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::slaves {

/// The object dictionary of a type of device: rows in ascending order with every value's place resolved. Built once
/// per type and shared by all devices of that type; the values themselves are in ObjectDictionary.
class DictionaryTable {
 public:
  /// `fixed_slots` numbers below that are used by rows which name their slot; the rows without one follow.
  /// Throws std::logic_error when two rows have one address or aliases disagree in type.
  DictionaryTable(std::initializer_list<std::span<const EntryRow>> parts, std::uint16_t fixed_slots);

  /// All of them, in ascending order of index and sub-index. \rtsafe
  [[nodiscard]] std::span<const EntryRow> rows() const noexcept { return rows_; }
  /// The rows of one object, empty when there is none.
  [[nodiscard]] std::span<const EntryRow> object(std::uint16_t index) const noexcept;
  /// One row, nullptr when there is none.
  [[nodiscard]] const EntryRow* find(std::uint16_t index, std::uint8_t subindex) const noexcept;
  /// The rows of the object behind those of `index`, in ascending order; empty at the end. Start with index 0.
  [[nodiscard]] std::span<const EntryRow> next_object(std::uint16_t index) const noexcept;

  /// Values an ObjectDictionary of this table holds as numbers; slots are below it.
  [[nodiscard]] std::uint16_t slot_count() const noexcept { return slot_count_; }
  /// Values it holds as bytes; slots of such rows are below it.
  [[nodiscard]] std::uint16_t string_count() const noexcept { return string_count_; }

 private:
  void assign_slots(std::uint16_t fixed_slots);

  std::vector<EntryRow> rows_;
  std::uint16_t slot_count_ = 0;
  std::uint16_t string_count_ = 0;
};

}  // namespace driveline::slaves
