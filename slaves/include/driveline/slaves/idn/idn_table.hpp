#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "driveline/slaves/idn/idn_row.hpp"

namespace driveline::slaves {

/// Operation data of a type of drive: rows in ascending order, each with a resolved slot. Built once per type and
/// shared by all drives of that type; the values themselves are in IdnValues.
class IdnTable {
 public:
  /// Slot numbers below `fixed_slots` are used by rows that name their slot; rows without a slot get the numbers from
  /// there on.
  /// Throws std::logic_error when two rows have the same number, a row is of another parameter set, a number has more
  /// than four bytes or an initial value outside its limits, a command has not two bytes, a content exceeds the
  /// capacity of its list, a list that follows from the table is writable, a slot is out of range, or the types of two
  /// rows with the same slot differ.
  IdnTable(std::initializer_list<std::span<const IdnRow>> parts, std::uint16_t fixed_slots);

  /// Returns all rows, in ascending order of the raw numbers. \rtsafe
  [[nodiscard]] std::span<const IdnRow> rows() const noexcept { return rows_; }
  /// Returns the row, or null when there is no such IDN. The time does not depend on the number of rows. \rtsafe
  [[nodiscard]] const IdnRow* find(wire::Idn idn) const noexcept;
  /// Returns the content of a list that follows from the table, encoded little endian. \rtsafe
  [[nodiscard]] std::span<const std::byte> selected(IdnSelection selection) const noexcept;

  /// Number of values of a drive; all slots are below this. \rtsafe
  [[nodiscard]] std::uint16_t slot_count() const noexcept { return static_cast<std::uint16_t>(places_.size()); }
  /// Bytes of all lists of a drive. \rtsafe
  [[nodiscard]] std::size_t list_bytes() const noexcept { return list_bytes_; }

  /// Memory of a list in the bytes of all lists.
  struct Place {
    std::uint32_t offset = 0;    ///< first byte
    std::uint16_t capacity = 0;  ///< bytes
  };
  /// Returns the memory of the list in this slot; capacity 0 when it has none. \rtsafe
  [[nodiscard]] const Place& place(std::uint16_t slot) const noexcept { return places_[slot]; }

 private:
  void make_index();
  void make_selections();
  void assign_slots(std::uint16_t fixed_slots);
  void check_aliases() const;

  std::vector<IdnRow> rows_;
  /// Position of a row + 1 by the number of the IDN, S and P; 0: there is none.
  std::vector<std::uint16_t> standard_;
  std::vector<std::uint16_t> product_;
  std::vector<std::vector<std::byte>> selections_;
  std::vector<Place> places_;
  std::size_t list_bytes_ = 0;
};

}  // namespace driveline::slaves
