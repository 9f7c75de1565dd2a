#include "driveline/slaves/od/object_dictionary.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

/// Returns the access bit for reading (bits 0..2) or writing (3..5) in `phase`; 0 when the phase allows no access.
constexpr std::uint16_t access_bit(AccessPhase phase, std::uint16_t while_configuring) noexcept {
  switch (phase) {
    case AccessPhase::kConfiguring:
      return while_configuring;
    case AccessPhase::kReady:
      return static_cast<std::uint16_t>(while_configuring << 1);
    case AccessPhase::kOperating:
      return static_cast<std::uint16_t>(while_configuring << 2);
    case AccessPhase::kClosed:
      break;
  }
  return 0;
}

/// Returns the number in the first bytes of `data`, sign extended.
std::uint64_t load_number(esi::DataType type, std::span<const std::byte> data) noexcept {
  const auto extended = [type](auto value) {
    using Unsigned = decltype(value);
    using Signed = std::make_signed_t<Unsigned>;
    return is_signed(type) ? static_cast<std::uint64_t>(std::int64_t{static_cast<Signed>(value)})
                           : std::uint64_t{value};
  };
  switch (byte_size(type)) {
    case 1:
      return extended(bytes::load_le<std::uint8_t>(data));
    case 2:
      return extended(bytes::load_le<std::uint16_t>(data));
    case 4:
      return extended(bytes::load_le<std::uint32_t>(data));
    default:
      return bytes::load_le<std::uint64_t>(data);
  }
}

void store_number(esi::DataType type, std::uint64_t raw, std::span<std::byte> out) noexcept {
  const auto bytes = bytes::to_le_bytes(raw);
  std::copy_n(bytes.begin(), byte_size(type), out.begin());
}

}  // namespace

SdoResult<void> check_range(const EntryRow& row, std::uint64_t raw) noexcept {
  const auto field = bit_size(row);
  if (field < 8 && !is_signed(row.type) && raw >> field != 0) return tl::unexpected(SdoAbort::kValueTooHigh);
  const double number = number_from_raw(row.type, raw);
  if (!std::isfinite(number)) return tl::unexpected(SdoAbort::kValueRange);
  if (number > row.maximum) return tl::unexpected(SdoAbort::kValueTooHigh);
  if (number < row.minimum) return tl::unexpected(SdoAbort::kValueTooLow);
  return {};
}

std::uint16_t read_access(AccessPhase phase) noexcept {
  return access_bit(phase, access::kReadConfiguring);
}

std::uint16_t write_access(AccessPhase phase) noexcept {
  return access_bit(phase, access::kWriteConfiguring);
}

ObjectDictionary::ObjectDictionary(const DictionaryTable& table)
    : table_(&table), values_(table.slot_count()), strings_(table.string_count()) {
  for (const auto& row : table.rows()) {
    if (is_string(row.type)) strings_[row.slot].reserve(row.string_length);  // so that later writes do not allocate
  }
  reset();
}

void ObjectDictionary::reset() {
  for (const auto& row : table_->rows()) {
    if (is_string(row.type)) {
      strings_[row.slot] = row.text;
    } else if (row.slot != slot::kConstant) {
      values_[row.slot] = initial_raw(row);
    }
  }
}

void ObjectDictionary::copy_backup_values(const ObjectDictionary& from, std::uint16_t first, std::uint16_t last) {
  for (const auto& row : table_->rows()) {
    if (row.index < first || row.index > last) continue;
    if ((row.access & access::kBackup) == 0 || row.slot == slot::kConstant) continue;
    if (is_string(row.type)) {
      strings_[row.slot] = from.strings_[row.slot];
    } else {
      values_[row.slot] = from.values_[row.slot];
    }
  }
}

SdoResult<const EntryRow*> ObjectDictionary::locate(std::uint16_t index, std::uint8_t subindex) const {
  if (table_->object(index).empty()) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  const auto* row = table_->find(index, subindex);
  if (row == nullptr) return tl::unexpected(SdoAbort::kSubindexDoesNotExist);
  return row;
}

SdoResult<std::size_t> ObjectDictionary::upload(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                                std::span<std::byte> out) const {
  const auto located = locate(index, subindex);
  if (!located) return tl::unexpected(located.error());
  const EntryRow& row = **located;
  if ((row.access & access::kRead) == 0) return tl::unexpected(SdoAbort::kWriteOnly);
  if ((row.access & read_access(phase)) == 0) return tl::unexpected(SdoAbort::kDeviceState);
  if (!is_string(row.type)) {
    store_number(row.type, raw(row), out);
    return byte_size(row.type);
  }
  const std::string& value = strings_[row.slot];
  const std::size_t length = std::max<std::size_t>(value.size(), row.string_length);
  std::fill_n(out.begin(), length, std::byte{0});
  std::transform(value.begin(), value.end(), out.begin(), [](char c) { return static_cast<std::byte>(c); });
  return length;
}

SdoResult<const EntryRow*> ObjectDictionary::writable(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                                      const DictionaryOwner& owner) const {
  const auto located = locate(index, subindex);
  if (!located) return located;
  const EntryRow& row = **located;
  if ((row.access & access::kWrite) == 0) return tl::unexpected(SdoAbort::kReadOnly);
  if ((row.access & write_access(phase)) == 0) return tl::unexpected(SdoAbort::kDeviceState);
  if (row.power_off_only && owner.power_stage_on()) return tl::unexpected(SdoAbort::kDeviceState);
  return &row;
}

SdoResult<void> ObjectDictionary::store_string(const EntryRow& row, std::span<const std::byte> data,
                                               DictionaryOwner& owner) {
  if (data.size() > row.string_length) return tl::unexpected(SdoAbort::kLengthTooHigh);
  std::string& value = strings_[row.slot];
  value.clear();
  for (const std::byte byte : data) {
    if (byte == std::byte{0} && row.type == esi::DataType::kVisibleString) break;
    value += static_cast<char>(byte);
  }
  owner.written(row);
  return {};
}

SdoResult<void> ObjectDictionary::download(std::uint16_t index, std::uint8_t subindex, AccessPhase phase,
                                           std::span<const std::byte> data, DictionaryOwner& owner, bool size_known) {
  const auto found = writable(index, subindex, phase, owner);
  if (!found) return tl::unexpected(found.error());
  const EntryRow& row = **found;
  if (is_string(row.type)) return store_string(row, data, owner);
  const std::size_t size = byte_size(row.type);
  if (data.size() < size) return tl::unexpected(SdoAbort::kLengthTooLow);
  if (data.size() > size && size_known) return tl::unexpected(SdoAbort::kLengthTooHigh);
  const std::uint64_t value = load_number(row.type, data);
  return check_range(row, value).and_then([&] { return owner.accept(row, value); }).map([&] {
    if (row.slot != slot::kConstant) values_[row.slot] = value;
    owner.written(row);
  });
}

}  // namespace driveline::slaves
