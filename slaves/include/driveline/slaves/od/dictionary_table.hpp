#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "driveline/slaves/od/entry_row.hpp"

namespace driveline::slaves {

/// Object dictionary of a device type: rows in ascending order, each with a resolved slot. Built once per type and
/// shared by all devices of that type; the values themselves are in ObjectDictionary.
class DictionaryTable {
 public:
  /// Slot numbers below `fixed_slots` are used by rows that name their slot; rows without a slot get the numbers from
  /// there on.
  /// Throws std::logic_error when two rows have the same address or aliases disagree in type or initial value, when a
  /// slot is out of range, or when there are too many values.
  DictionaryTable(std::initializer_list<std::span<const EntryRow>> parts, std::uint16_t fixed_slots);

  /// Returns all rows, in ascending order of index and sub-index. \rtsafe
  [[nodiscard]] std::span<const EntryRow> rows() const noexcept { return rows_; }
  /// Returns the rows of an object; empty when it does not exist.
  [[nodiscard]] std::span<const EntryRow> object(std::uint16_t index) const noexcept;
  /// Returns a row, or nullptr when it does not exist.
  [[nodiscard]] const EntryRow* find(std::uint16_t index, std::uint8_t subindex) const noexcept;
  /// Returns the rows of the next object after `index`; empty at the end. Start with index 0.
  [[nodiscard]] std::span<const EntryRow> next_object(std::uint16_t index) const noexcept;

  /// Number of values that an ObjectDictionary of this table stores as numbers; their slots are below this.
  [[nodiscard]] std::uint16_t slot_count() const noexcept { return slot_count_; }
  /// Number of values that an ObjectDictionary of this table stores as bytes; the slots of such rows are below this.
  [[nodiscard]] std::uint16_t string_count() const noexcept { return string_count_; }

 private:
  void assign_slots(std::uint16_t fixed_slots);

  std::vector<EntryRow> rows_;
  std::uint16_t slot_count_ = 0;
  std::uint16_t string_count_ = 0;
};

}  // namespace driveline::slaves
