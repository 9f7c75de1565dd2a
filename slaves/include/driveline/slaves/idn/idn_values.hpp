#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "driveline/slaves/idn/idn_table.hpp"

namespace driveline::slaves {

/// Values of the operation data of one drive, by slot. Not thread safe: belongs to the thread that runs the device.
class IdnValues {
 public:
  /// Sets all values to their initial ones. Allocates all memory in advance; the table must outlive this.
  explicit IdnValues(const IdnTable& table);

  /// Returns the table that was passed to the constructor. \rtsafe
  [[nodiscard]] const IdnTable& table() const noexcept { return *table_; }

  /// \rtsafe
  template <typename T>
  [[nodiscard]] T get(Slot<T> slot) const noexcept {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, float>) {
      return std::bit_cast<float>(static_cast<std::uint32_t>(numbers_[slot.number]));
    } else {
      return static_cast<T>(numbers_[slot.number]);
    }
  }
  /// Sets a value of the slot's type; there is no conversion, and limits are not checked. \rtsafe
  template <typename T, std::same_as<T> Value>
  void set(Slot<T> slot, Value value) noexcept {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, float>) {
      numbers_[slot.number] = std::bit_cast<std::uint32_t>(value);
    } else if constexpr (std::is_signed_v<T>) {
      numbers_[slot.number] = static_cast<std::uint64_t>(std::int64_t{value});  // sign extended
    } else {
      numbers_[slot.number] = value;
    }
  }

  /// Returns the content of a list or text, without its header. \rtsafe
  [[nodiscard]] std::span<const std::byte> get(Slot<IdnList> slot) const noexcept;
  /// Sets the content of a list or text; what exceeds its capacity is cut off. \rtsafe
  void set(Slot<IdnList> slot, std::span<const std::byte> content) noexcept;
  /// Returns a procedure command. \rtsafe
  [[nodiscard]] IdnCommand get(Slot<IdnCommand> slot) const noexcept;
  /// Sets a procedure command. \rtsafe
  void set(Slot<IdnCommand> slot, IdnCommand command) noexcept;

  /// Returns the value of a number as its bits: two's complement, sign extended, or the IEEE 754 bits of a float.
  /// \rtsafe
  [[nodiscard]] std::uint64_t raw(const IdnRow& row) const noexcept { return numbers_[row.slot]; }
  /// Sets the value of a number by its bits. \rtsafe
  void set_raw(const IdnRow& row, std::uint64_t raw) noexcept { numbers_[row.slot] = raw; }

 private:
  const IdnTable* table_;
  /// Numbers; of a list its length, of a command its value and above it its state.
  std::vector<std::uint64_t> numbers_;
  std::vector<std::byte> lists_;
};

/// Returns the bits of a number from its little-endian bytes, at most the length of the row: sign extended. \rtsafe
[[nodiscard]] std::uint64_t raw_from_bytes(const wire::SoeAttribute& attribute,
                                           std::span<const std::byte> bytes) noexcept;
/// Writes the bits of a number as little-endian bytes; as many as `out` has, at most 8. \rtsafe
void raw_to_bytes(std::uint64_t raw, std::span<std::byte> out) noexcept;
/// Returns the number that the bits represent. \rtsafe
[[nodiscard]] double number_from_raw(const wire::SoeAttribute& attribute, std::uint64_t raw) noexcept;
/// Returns the bits of a number that the row can represent. \rtsafe
[[nodiscard]] std::uint64_t raw_from_number(const wire::SoeAttribute& attribute, double number) noexcept;

}  // namespace driveline::slaves
