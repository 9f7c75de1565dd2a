#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "driveline/slaves/od/dictionary_table.hpp"
#include "driveline/slaves/od/slot.hpp"
#include "driveline/wire/sdo_abort.hpp"

namespace driveline::slaves {

template <typename T>
/// A value, or the abort code of the SDO response.
using SdoResult = tl::expected<T, wire::SdoAbort>;

/// Checks that `raw` is within the range of the row, and finite. \rtsafe
[[nodiscard]] SdoResult<void> check_range(const EntryRow& row, std::uint64_t raw) noexcept;

/// Returns the access bit that a row needs to be read in `phase`; 0 when the phase allows no access.
[[nodiscard]] std::uint16_t read_access(AccessPhase phase) noexcept;
/// Returns the access bit that a row needs to be written in `phase`; 0 when the phase allows no access.
[[nodiscard]] std::uint16_t write_access(AccessPhase phase) noexcept;

/// The application that owns a dictionary: it may refuse a value, and is notified of every change.
class DictionaryOwner {
 public:
  virtual ~DictionaryOwner() = default;
  /// Called before a value is stored that has a valid length and range in a row that is writable in this phase; the
  /// application may still refuse it.
  [[nodiscard]] virtual SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) = 0;
  /// Called after the value has been stored.
  virtual void written(const EntryRow& row) = 0;
  /// Whether the power stage is on; rows with `power_off_only` are locked while it is.
  [[nodiscard]] virtual bool power_stage_on() const noexcept = 0;
};

/// Values of a device: access by address with all checks of the table for the bus, and access by typed slot for the
/// application. Values have 64 bits each; strings are stored separately. Not thread safe: belongs to the thread that
/// runs the device.
class ObjectDictionary {
 public:
  /// Sets all values to their initial ones. Allocates all memory in advance; the table must outlive this.
  explicit ObjectDictionary(const DictionaryTable& table);

  /// Returns the table that was passed to the constructor. \rtsafe
  [[nodiscard]] const DictionaryTable& table() const noexcept { return *table_; }

  /// \rtsafe
  template <typename T>
  [[nodiscard]] T get(Slot<T> slot) const noexcept {
    if constexpr (std::is_same_v<T, float>) {
      return std::bit_cast<float>(static_cast<std::uint32_t>(values_[slot.number]));
    } else {
      return static_cast<T>(values_[slot.number]);
    }
  }
  /// Sets a value of the slot's type; there is no conversion. \rtsafe
  template <typename T, std::same_as<T> Value>
  void set(Slot<T> slot, Value value) noexcept {
    if constexpr (std::is_same_v<T, float>) {
      values_[slot.number] = std::bit_cast<std::uint32_t>(value);
    } else if constexpr (std::is_signed_v<T>) {
      values_[slot.number] = static_cast<std::uint64_t>(std::int64_t{value});  // sign extended
    } else {
      values_[slot.number] = value;
    }
  }

  /// \name Raw values Access by row, untyped: two's complement, sign extended, or the IEEE 754 bits of a REAL.
  /// @{

  /// Returns the raw value of a slot. \rtsafe
  [[nodiscard]] std::uint64_t raw(std::uint16_t slot) const noexcept { return values_[slot]; }
  /// Returns the raw values of all slots. \rtsafe
  [[nodiscard]] std::span<const std::uint64_t> raw_values() const noexcept { return values_; }
  /// Sets the raw value of a slot. \rtsafe
  void set_raw(std::uint16_t slot, std::uint64_t raw) noexcept { values_[slot] = raw; }
  /// Returns the raw value of any numeric row, constants included. \rtsafe
  [[nodiscard]] std::uint64_t raw(const EntryRow& row) const noexcept {
    return row.slot == slot::kConstant ? initial_raw(row) : values_[row.slot];
  }
  /// @}

  /// Returns the value of a row that is stored as bytes; its capacity is the declared length.
  [[nodiscard]] std::string& text(std::uint16_t string_slot) noexcept { return strings_[string_slot]; }
  /// See text() above; read only.
  [[nodiscard]] const std::string& text(std::uint16_t string_slot) const noexcept { return strings_[string_slot]; }

  /// SDO upload of a sub-index: returns the number of bytes written to `out`, or the abort code. `out` must be large
  /// enough for the longest string.
  [[nodiscard]] SdoResult<std::size_t> upload(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                              std::span<std::byte> out) const;
  /// SDO download of a sub-index. `size_known` is false for an expedited transfer without size: of its four bytes, the
  /// object uses as many as it needs.
  [[nodiscard]] SdoResult<void> download(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                         std::span<const std::byte> data, DictionaryOwner& owner,
                                         bool size_known = true);
  /// Returns the row that a download to this sub-index would change, or the abort code if it cannot be written now.
  [[nodiscard]] SdoResult<const EntryRow*> writable(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                                    const DictionaryOwner& owner) const;

  /// Resets every value to its initial one.
  void reset();
  /// Copies only the rows that "store parameters" stores, with an index from `first` to `last`.
  void copy_backup_values(const ObjectDictionary& from, std::uint16_t first = 0, std::uint16_t last = 0xFFFF);

 private:
  [[nodiscard]] SdoResult<const EntryRow*> locate(std::uint16_t index, std::uint8_t subindex) const;
  [[nodiscard]] SdoResult<void> store_string(const EntryRow& row, std::span<const std::byte> data,
                                             DictionaryOwner& owner);

  const DictionaryTable* table_;
  std::vector<std::uint64_t> values_;
  std::vector<std::string> strings_;
};

}  // namespace driveline::slaves
