#include "driveline/slaves/pdo/pdo_map.hpp"

#include <algorithm>
#include <type_traits>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/bit_copy.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

constexpr std::uint32_t kMaxSyncManagers = 32;

/// Whether `sync_managers` has a bit for the assignment object `index`.
bool assigns_to(std::uint32_t sync_managers, std::uint16_t index) noexcept {
  const std::uint16_t first = assignment_object(0);
  return index >= first && index < first + kMaxSyncManagers && (sync_managers >> (index - first) & 1U) != 0;
}

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
  return row == nullptr ? 0 : static_cast<std::uint32_t>(dictionary.raw(*row));
}

/// Whether the entry is a dummy: one of the data types BOOLEAN to UNSIGNED32 with its length (CiA 301 7.4.7).
bool is_dummy(const MappingEntry& entry) noexcept {
  if (entry.index < static_cast<unsigned>(esi::DataType::kBoolean)) return false;
  if (entry.index > static_cast<unsigned>(esi::DataType::kUnsigned32) || entry.subindex != 0) return false;
  EntryRow row;
  row.type = static_cast<esi::DataType>(entry.index);
  return entry.bits == bit_size(row);
}

PdoMap::Storage storage_of(const EntryRow& row) noexcept {
  if (is_string(row.type)) return PdoMap::Storage::kText;
  if (row.slot == slot::kConstant) return PdoMap::Storage::kConstant;
  return is_signed(row.type) ? PdoMap::Storage::kSigned : PdoMap::Storage::kUnsigned;
}

bool in_block(std::uint16_t index, std::uint16_t first, std::uint16_t count) noexcept {
  return index >= first && index < first + count;
}

SdoResult<void> check_mapping_entry(const ObjectDictionary& dictionary, const PdoLimits& limits, std::uint16_t mappable,
                                    std::uint32_t raw) {
  if (raw == 0) return {};  // clears the entry
  const MappingEntry entry(raw);
  if (limits.gaps && entry.index == 0 && entry.bits != 0) return {};
  if (limits.dummies && mappable == access::kRxMappable && is_dummy(entry)) return {};
  if (dictionary.table().object(entry.index).empty()) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  const auto* row = dictionary.table().find(entry.index, entry.subindex);
  if (row == nullptr) return tl::unexpected(SdoAbort::kSubindexDoesNotExist);
  if ((row->access & mappable) == 0 || entry.bits != bit_size(*row)) return tl::unexpected(SdoAbort::kNotMappable);
  return {};
}

/// An entry of a mapping with the value that it would get.
struct NewEntry {
  std::uint8_t subindex = 0;  ///< 0: none
  std::uint32_t raw = 0;
};

SdoResult<void> check_mapping_count(const ObjectDictionary& dictionary, const PdoLimits& limits, std::uint16_t index,
                                    std::uint16_t mappable, std::uint32_t count, const NewEntry& entry = {}) {
  if (count > limits.objects) return tl::unexpected(SdoAbort::kMappingTooLong);
  unsigned bits = 0;
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    const std::uint32_t raw =
        sub == entry.subindex ? entry.raw : value_of(dictionary, index, static_cast<std::uint8_t>(sub));
    if (raw == 0) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
    const auto valid = check_mapping_entry(dictionary, limits, mappable, raw);
    if (!valid) return valid;
    bits += MappingEntry(raw).bits;
  }
  if (bits > 8U * limits.bytes) return tl::unexpected(SdoAbort::kMappingTooLong);
  if (limits.even_bytes && bits % 16 != 0) return tl::unexpected(SdoAbort::kParameterIncompatible);
  return {};
}

/// Whether `raw` is the index of an existing PDO of the direction that starts at `first`.
bool is_pdo(const ObjectDictionary& dictionary, const PdoLimits& limits, std::uint16_t first, std::uint32_t raw) {
  const auto index = static_cast<std::uint16_t>(raw);
  return in_block(index, first, limits.pdos) && !dictionary.table().object(index).empty();
}

SdoResult<void> check_assignment_count(const ObjectDictionary& dictionary, std::uint16_t index, std::uint16_t first,
                                       const PdoLimits& limits, std::uint32_t count) {
  if (count > limits.pdos) return tl::unexpected(SdoAbort::kValueTooHigh);
  for (std::uint32_t sub = 1; sub <= count; ++sub) {
    const auto pdo = value_of(dictionary, index, static_cast<std::uint8_t>(sub));
    if (!is_pdo(dictionary, limits, first, pdo)) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
    for (std::uint32_t before = 1; before < sub; ++before) {
      if (value_of(dictionary, index, static_cast<std::uint8_t>(before)) == pdo) {
        return tl::unexpected(SdoAbort::kParameterIncompatible);
      }
    }
  }
  return {};
}

}  // namespace

SdoResult<void> check_pdo_write(const ObjectDictionary& dictionary, const PdoLimits& limits, const EntryRow& row,
                                std::uint64_t raw) {
  const bool rx_mapping = in_block(row.index, limits.rx_first, limits.pdos);
  const bool tx_mapping = in_block(row.index, limits.tx_first, limits.pdos);
  const bool rx_assignment = assigns_to(limits.output_sync_managers, row.index);
  const bool tx_assignment = assigns_to(limits.input_sync_managers, row.index);
  const bool assignment = rx_assignment || tx_assignment;
  if (!rx_mapping && !tx_mapping && !assignment) return {};
  const auto value = static_cast<std::uint32_t>(raw);
  const std::uint16_t mappable = rx_mapping ? access::kRxMappable : access::kTxMappable;
  const std::uint16_t first = rx_assignment ? limits.rx_first : limits.tx_first;
  if (row.subindex == 0) {
    return assignment ? check_assignment_count(dictionary, row.index, first, limits, value)
                      : check_mapping_count(dictionary, limits, row.index, mappable, value);
  }
  const std::uint32_t count = value_of(dictionary, row.index, 0);
  if (count != 0 && (assignment || limits.locked)) return tl::unexpected(SdoAbort::kSubindexCannotBeWritten);
  if (!assignment && row.subindex <= count) {
    return check_mapping_count(dictionary, limits, row.index, mappable, count, {row.subindex, value});
  }
  if (!assignment) return check_mapping_entry(dictionary, limits, mappable, value);
  if (value != 0 && !is_pdo(dictionary, limits, first, value)) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  return {};
}

void PdoMap::append(const ObjectDictionary& dictionary, std::uint32_t entry) noexcept {
  const MappingEntry mapping(entry);
  const auto* row = dictionary.table().find(mapping.index, mapping.subindex);
  const auto offset = static_cast<std::uint32_t>(bits_);
  bits_ += mapping.bits;
  if (mapping.index == 0 || row == nullptr || fields_.size() == fields_.capacity()) return;
  const auto storage = storage_of(*row);
  if (storage == PdoMap::Storage::kText && mapping.bits > 8U * row->string_length) return;
  fields_.push_back({row, offset, row->slot, mapping.bits, storage});
  append_copy(fields_.back());
}

void PdoMap::clear() noexcept {
  fields_.clear();
  copies_.clear();
  bits_ = 0;
  ends_ = {};
  copies_only_ = true;
}

void PdoMap::append_pdo(const ObjectDictionary& dictionary, std::uint16_t mapping, const PdoLimits& limits) noexcept {
  const std::uint32_t objects = value_of(dictionary, mapping, 0);
  for (std::uint32_t sub = 1; sub <= std::min<std::uint32_t>(objects, limits.objects); ++sub) {
    append(dictionary, value_of(dictionary, mapping, static_cast<std::uint8_t>(sub)));
  }
}

void PdoMap::build(const ObjectDictionary& dictionary, std::size_t sync_manager, const PdoLimits& limits) noexcept {
  clear();
  const std::uint16_t assignment = assignment_object(sync_manager);
  const std::uint32_t pdos = value_of(dictionary, assignment, 0);
  for (std::uint32_t i = 1; i <= std::min<std::uint32_t>(pdos, limits.pdos); ++i) {
    append_pdo(dictionary, static_cast<std::uint16_t>(value_of(dictionary, assignment, static_cast<std::uint8_t>(i))),
               limits);
  }
}

void PdoMap::build_pdo(const ObjectDictionary& dictionary, std::uint16_t mapping, const PdoLimits& limits) noexcept {
  clear();
  append_pdo(dictionary, mapping, limits);
}

namespace {

/// Returns the number of bytes when the field consists of whole bytes and starts at a byte boundary, else 0.
std::size_t whole_bytes(const PdoMap::Field& field) noexcept {
  return (field.bit_offset | field.bits) % 8 == 0 ? field.bits / 8U : 0U;
}

std::uint64_t load_field(const PdoMap::Field& field, std::span<const std::byte> data) noexcept {
  const auto bytes = data.subspan(field.bit_offset / 8);
  std::uint64_t value = 0;
  switch (whole_bytes(field)) {
    case 1:
      value = bytes::load_le<std::uint8_t>(bytes);
      break;
    case 2:
      value = bytes::load_le<std::uint16_t>(bytes);
      break;
    case 4:
      value = bytes::load_le<std::uint32_t>(bytes);
      break;
    default:
      value = load_bits(data, field.bit_offset, field.bits);
      break;
  }
  return field.storage == PdoMap::Storage::kSigned ? sign_extended(value, field.bits) : value;
}

void store_field(const PdoMap::Field& field, std::uint64_t value, std::span<std::byte> data) noexcept {
  const auto bytes = data.subspan(field.bit_offset / 8);
  switch (whole_bytes(field)) {
    case 1:
      return bytes::store_le(bytes, static_cast<std::uint8_t>(value));
    case 2:
      return bytes::store_le(bytes, static_cast<std::uint16_t>(value));
    case 4:
      return bytes::store_le(bytes, static_cast<std::uint32_t>(value));
    default:
      return store_bits(data, field.bit_offset, field.bits, value);
  }
}

/// Loads a value that is stored as bytes. It may cross byte boundaries, so it is copied in steps of 8 bits.
void load_text(const PdoMap::Field& field, std::span<const std::byte> data, std::string& text) noexcept {
  text.assign((field.bits + 7U) / 8U, '\0');
  for (std::size_t bit = 0; bit < field.bits; bit += 8) {
    const auto count = std::min<std::size_t>(8, field.bits - bit);
    text[bit / 8] = static_cast<char>(load_bits(data, field.bit_offset + bit, count));
  }
}

void store_text(const PdoMap::Field& field, const std::string& text, std::span<std::byte> data) noexcept {
  for (std::size_t bit = 0; bit < field.bits; bit += 8) {
    const auto count = std::min<std::size_t>(8, field.bits - bit);
    const auto byte = bit / 8 < text.size() ? static_cast<unsigned char>(text[bit / 8]) : std::uint8_t{0};
    store_bits(data, field.bit_offset + bit, count, byte);
  }
}

}  // namespace

const PdoMap::Field* PdoMap::find(std::uint16_t index, std::uint8_t subindex) const noexcept {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const Field& field) {
    return field.row != nullptr && field.row->index == index && field.row->subindex == subindex;
  });
  return found == fields_.end() ? nullptr : &*found;
}

namespace {

void decode_field(const PdoMap::Field& field, std::span<const std::byte> data, ObjectDictionary& dictionary) noexcept {
  if (std::size_t{field.bit_offset} + field.bits > 8 * data.size()) return;
  if (field.is_text()) return load_text(field, data, dictionary.text(field.slot));
  if (field.is_number()) dictionary.set_raw(field.slot, load_field(field, data));
}

void encode_field(const PdoMap::Field& field, const ObjectDictionary& dictionary, std::span<std::byte> data) noexcept {
  if (std::size_t{field.bit_offset} + field.bits > 8 * data.size()) return;
  if (field.is_text()) return store_text(field, dictionary.text(field.slot), data);
  store_field(field, dictionary.raw(*field.row), data);
}

}  // namespace

/// Keeps the copies sorted by kind; those of the same kind stay in the order of the process data.
void PdoMap::append_copy(const Field& field) noexcept {
  const std::size_t bytes = field.is_number() ? whole_bytes(field) : 0;
  if (bytes != 4 && bytes != 2 && bytes != 1) {
    copies_only_ = false;
    return;
  }
  const std::size_t unsigned_behind = field.storage == Storage::kSigned ? 0 : 1;
  const std::size_t kind = (bytes == 4 ? kSigned32 : bytes == 2 ? kSigned16 : kSigned8) + unsigned_behind;
  copies_.insert(copies_.begin() + ends_[kind], {static_cast<std::uint16_t>(field.bit_offset / 8), field.slot});
  for (std::size_t later = kind; later < kKinds; ++later) ++ends_[later];
}

/// Copies entry by entry, for entries that are no whole bytes, or data that do not contain all entries.
void PdoMap::decode_fields(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept {
  for (const Field& field : fields_) decode_field(field, data, dictionary);
}

void PdoMap::encode_fields(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept {
  for (const Field& field : fields_) encode_field(field, dictionary, data);
}

void PdoMap::decode(std::span<const std::byte> data, ObjectDictionary& dictionary) const noexcept {
  if (!copies_only_ || data.size() < size()) return decode_fields(data, dictionary);
  const Copy* copy = copies_.data();
  const auto copy_kind = [&]<typename T>(Kind kind, T /*type*/) {
    for (const Copy* const last = copies_.data() + ends_[kind]; copy != last; ++copy) {
      using Unsigned = std::make_unsigned_t<T>;
      const auto value = static_cast<T>(bytes::load_le<Unsigned>(data.subspan(copy->place)));
      dictionary.set_raw(copy->slot, static_cast<std::uint64_t>(std::int64_t{value}));  // extends the sign
    }
  };
  copy_kind(kSigned32, std::int32_t{});
  copy_kind(kUnsigned32, std::uint32_t{});
  copy_kind(kSigned16, std::int16_t{});
  copy_kind(kUnsigned16, std::uint16_t{});
  copy_kind(kSigned8, std::int8_t{});
  copy_kind(kUnsigned8, std::uint8_t{});
}

void PdoMap::encode(const ObjectDictionary& dictionary, std::span<std::byte> data) const noexcept {
  if (!copies_only_ || data.size() < size()) return encode_fields(dictionary, data);
  const auto values = dictionary.raw_values();
  const Copy* copy = copies_.data();
  const auto copy_until = [&]<typename T>(Kind kind, T /*type*/) {
    for (const Copy* const last = copies_.data() + ends_[kind]; copy != last; ++copy) {
      bytes::store_le(data.subspan(copy->place), static_cast<T>(values[copy->slot]));
    }
  };
  copy_until(kUnsigned32, std::uint32_t{});
  copy_until(kUnsigned16, std::uint16_t{});
  copy_until(kUnsigned8, std::uint8_t{});
}

}  // namespace driveline::slaves
