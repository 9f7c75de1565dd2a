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
/// A value, or the abort code that the SDO service answers with.
using SdoResult = tl::expected<T, wire::SdoAbort>;

/// `raw` is within the range of the row, and finite. \rtsafe
[[nodiscard]] SdoResult<void> check_range(const EntryRow& row, std::uint64_t raw) noexcept;

/// Access right that a row must have to be read or written in `phase`; 0 where nothing is.
[[nodiscard]] std::uint16_t read_access(AccessPhase phase) noexcept;
/// See read_access().
[[nodiscard]] std::uint16_t write_access(AccessPhase phase) noexcept;

/// The application behind a dictionary: may refuse a value and is told of every change.
class DictionaryOwner {
 public:
  virtual ~DictionaryOwner() = default;
  /// The value has the right length and range and the row may be written in this phase; the application may still
  /// refuse it.
  [[nodiscard]] virtual SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) = 0;
  /// The value has been stored.
  virtual void written(const EntryRow& row) = 0;
  /// Whether the power stage is on (rows with `power_off_only` are locked then).
  [[nodiscard]] virtual bool power_stage_on() const noexcept = 0;
};

/// The values of one device: access by address with every check of the table for the bus, and access by typed slot for
/// the application. Values are 64 bits each; strings live apart. Not thread safe: belongs to the thread that runs the
/// device.
class ObjectDictionary {
 public:
  /// All values as the table has them initially. Allocates all it will need; the table must outlive this.
  explicit ObjectDictionary(const DictionaryTable& table);

  /// As given to the constructor. \rtsafe
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
  /// The value has the type of the slot, without conversion. \rtsafe
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

  /// \name Raw values Access by row, without the type: two's complement sign extended, or the IEEE 754 bits of a REAL.
  /// @{

  /// Of a slot. \rtsafe
  [[nodiscard]] std::uint64_t raw(std::uint16_t slot) const noexcept { return values_[slot]; }
  /// See raw(). \rtsafe
  void set_raw(std::uint16_t slot, std::uint64_t raw) noexcept { values_[slot] = raw; }
  /// Raw value of any numeric row, constants included.
  [[nodiscard]] std::uint64_t raw(const EntryRow& row) const noexcept;
  /// @}

  /// Value of a row that is kept as bytes; its capacity is the declared length.
  [[nodiscard]] std::string& text(std::uint16_t string_slot) noexcept { return strings_[string_slot]; }
  /// The same, read only.
  [[nodiscard]] const std::string& text(std::uint16_t string_slot) const noexcept { return strings_[string_slot]; }

  /// SDO upload of one sub-index: bytes written to `out`, or the abort code. `out` must hold the longest string.
  [[nodiscard]] SdoResult<std::size_t> upload(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                              std::span<std::byte> out) const;
  /// SDO download of one sub-index. `size_known` false: an expedited transfer without size, four bytes of which the
  /// object takes what it needs.
  [[nodiscard]] SdoResult<void> download(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                         std::span<const std::byte> data, DictionaryOwner& owner,
                                         bool size_known = true);
  /// The row a download to this sub-index would change; the abort code if it cannot be written now.
  [[nodiscard]] SdoResult<const EntryRow*> writable(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                                    const DictionaryOwner& owner) const;

  /// Puts every value back to its initial one.
  void reset();
  /// Only the rows that "store parameters" keeps.
  void copy_backup_values(const ObjectDictionary& from);

 private:
  [[nodiscard]] SdoResult<const EntryRow*> locate(std::uint16_t index, std::uint8_t subindex) const;
  [[nodiscard]] SdoResult<void> store_string(const EntryRow& row, std::span<const std::byte> data,
                                             DictionaryOwner& owner);

  const DictionaryTable* table_;
  std::vector<std::uint64_t> values_;
  std::vector<std::string> strings_;
};

}  // namespace driveline::slaves
