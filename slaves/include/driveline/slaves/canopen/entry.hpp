#pragma once

#include "driveline/canopen_wire/cob_id.hpp"
#include "driveline/slaves/od/object_dictionary.hpp"

/// CANopen devices according to CiA 301, each from one object dictionary.
namespace driveline::slaves::cia301 {

/// An entry of the dictionary that a service uses. A device without it behaves as with the value 0. \rtsafe throughout.
class Entry {
 public:
  /// An entry that does not exist.
  Entry() = default;
  /// The dictionary must outlive this.
  Entry(ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t subindex) noexcept
      : dictionary_(&dictionary), row_(dictionary.table().find(index, subindex)) {}

  /// Whether the device has it.
  [[nodiscard]] bool exists() const noexcept { return row_ != nullptr; }
  /// Whether `row` is this entry.
  [[nodiscard]] bool is(const EntryRow& row) const noexcept { return row_ == &row; }
  /// Its value, zero extended.
  [[nodiscard]] std::uint32_t value() const noexcept {
    return exists() ? static_cast<std::uint32_t>(dictionary_->raw(*row_)) : 0;
  }
  /// Sets the value; without effect where the entry does not exist or never changes.
  void set(std::uint32_t value) noexcept {
    if (exists() && row_->slot != slot::kConstant) dictionary_->set_raw(row_->slot, value);
  }
  /// The value as a COB-ID.
  [[nodiscard]] canopen::CobId cob_id() const noexcept { return {value()}; }

 private:
  ObjectDictionary* dictionary_ = nullptr;
  const EntryRow* row_ = nullptr;
};

/// Rule of CiA 301 for a COB-ID of which bit 31 means "does not exist" (PDO, EMCY): the identifier, bits 0-29, changes
/// only while the message does not exist, or ceases to; an existing one must not have a restricted identifier. Error:
/// kValueRange. \rtsafe
[[nodiscard]] SdoResult<void> check_cob_id(canopen::CobId before, canopen::CobId after) noexcept;

}  // namespace driveline::slaves::cia301
