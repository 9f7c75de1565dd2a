#include "driveline/slaves/coe/complete_access.hpp"

#include <algorithm>
#include <optional>

#include "driveline/bytes/endian.hpp"
#include "driveline/slaves/bit_copy.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;

constexpr std::size_t kFirstEntryBit = 16;  ///< sub-index 0 has eight bits, followed by eight unused bits

/// Iterates over the entries of an object and computes their positions.
class Layout {
 public:
  Layout(std::span<const EntryRow> rows, std::uint8_t first) noexcept : rows_(rows), first_(first) {}

  /// Calls `visit(row, bit offset)` for the sub-indices from `first` up to `last`.
  template <typename Visit>
  void each(std::uint32_t last, Visit&& visit) const {
    std::size_t behind = kFirstEntryBit;
    const std::size_t start = first_ == 0 ? 0 : kFirstEntryBit;
    for (const auto& row : rows_) {
      if (row.subindex == 0) {
        if (first_ == 0) visit(row, std::size_t{0});
        continue;
      }
      if (row.subindex > last) return;
      // An entry before bit 16 would overlap the count; such an offset is ignored.
      const bool placed = row.bit_offset != EntryRow::kBehindPrevious && row.bit_offset >= kFirstEntryBit;
      const std::size_t offset = placed ? row.bit_offset : behind;
      behind = offset + bit_size(row);
      visit(row, offset - start);
    }
  }

  /// Returns the size in bytes up to the end of sub-index `last`.
  [[nodiscard]] std::size_t bytes(std::uint32_t last) const noexcept {
    std::size_t bits = 0;
    each(last, [&bits](const EntryRow& row, std::size_t offset) {
      bits = std::max(bits, row.subindex == 0 ? kFirstEntryBit : offset + bit_size(row));
    });
    return (bits + 7) / 8;
  }

 private:
  std::span<const EntryRow> rows_;
  std::uint8_t first_;
};

constexpr std::uint32_t kAllSubindices = 0xFF;

/// Returns entry 0 if it is the number of entries; null when the object starts with data.
const EntryRow* count_row(std::span<const EntryRow> rows) noexcept {
  const auto& row = rows.front();
  return row.subindex == 0 && row.type == esi::DataType::kUnsigned8 ? &row : nullptr;
}

std::uint32_t last_subindex(const ObjectDictionary& dictionary, std::span<const EntryRow> rows) noexcept {
  const auto* count = count_row(rows);
  return count == nullptr ? kAllSubindices : static_cast<std::uint32_t>(dictionary.raw(*count));
}

SdoResult<std::span<const EntryRow>> locate(const ObjectDictionary& dictionary, std::uint16_t index,
                                            std::uint8_t first) {
  const auto rows = dictionary.table().object(index);
  if (rows.empty()) return tl::unexpected(SdoAbort::kObjectDoesNotExist);
  if (first > 1 || rows.front().code == esi::ObjectCode::kVariable) {
    return tl::unexpected(SdoAbort::kUnsupportedAccess);
  }
  return rows;
}

/// Stores the values of an object, so that a failed download can restore them.
class Snapshot {
 public:
  Snapshot(ObjectDictionary& dictionary, std::span<const EntryRow> rows) : dictionary_(dictionary), rows_(rows) {
    for (const auto& row : rows) {
      numbers_.push_back(is_string(row.type) ? 0 : dictionary.raw(row));
      texts_.push_back(is_string(row.type) ? dictionary.text(row.slot) : std::string{});
    }
  }
  void restore(DictionaryOwner& owner) {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (is_string(rows_[i].type)) {
        dictionary_.text(rows_[i].slot) = texts_[i];
      } else if (rows_[i].slot != slot::kConstant) {
        dictionary_.set_raw(rows_[i].slot, numbers_[i]);
      }
    }
    owner.written(rows_.front());
  }

 private:
  ObjectDictionary& dictionary_;
  std::span<const EntryRow> rows_;
  std::vector<std::uint64_t> numbers_;
  std::vector<std::string> texts_;
};

bool can_write(const EntryRow& row) noexcept {
  return (row.access & access::kWrite) != 0;
}

/// A download in progress, with the data that all its steps need.
struct Download {
  ObjectDictionary& dictionary;
  std::span<const EntryRow> rows;
  std::uint8_t first;
  AccessPhase phase;
  std::span<const std::byte> data;
  DictionaryOwner& owner;

  SdoResult<void> write(const EntryRow& row, std::span<const std::byte> value) const {
    return dictionary.download(row.index, row.subindex, phase, value, owner);
  }

  SdoResult<void> write_entries(std::uint32_t last) const {
    SdoResult<void> result;
    std::vector<std::byte> value;
    Layout(rows, first).each(last, [&](const EntryRow& row, std::size_t offset) {
      if (!result || row.subindex == 0 || !can_write(row)) return;
      value.assign(byte_size(row), std::byte{0});
      copy_bits(data, offset, value, 0, std::min(bit_size(row), 8 * value.size()));
      result = write(row, value);
    });
    return result;
  }

  SdoResult<void> write_all(const EntryRow* count, std::uint32_t last) const {
    if (count == nullptr) return write_entries(last);
    return write(*count, bytes::to_le_bytes<std::uint8_t>(0))
        .and_then([&] { return write_entries(last); })
        .and_then([&] { return write(*count, data.first<1>()); });
  }
};

}  // namespace

std::size_t complete_size(std::span<const EntryRow> rows, std::uint8_t first) noexcept {
  return Layout(rows, first).bytes(kAllSubindices);
}

SdoResult<std::size_t> upload_complete(const ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t first,
                                       AccessPhase phase, std::span<std::byte> out) {
  const auto located = locate(dictionary, index, first);
  if (!located) return tl::unexpected(located.error());
  const Layout layout(*located, first);
  const auto last = last_subindex(dictionary, *located);
  const std::size_t size = layout.bytes(last);
  std::fill_n(out.begin(), size, std::byte{0});
  std::vector<std::byte> value;
  bool any = false;
  SdoAbort why = SdoAbort::kWriteOnly;
  layout.each(last, [&](const EntryRow& row, std::size_t offset) {
    value.assign(byte_size(row), std::byte{0});
    const auto read = dictionary.upload(row.index, row.subindex, phase, value);
    if (read) copy_bits(value, 0, out, offset, std::min(bit_size(row), 8 * *read));
    if (!read && read.error() != SdoAbort::kWriteOnly) why = read.error();
    any = any || read.has_value();
  });
  if (!any && size != 0) return tl::unexpected(why);
  return size;
}

SdoResult<std::size_t> writable_complete(const ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t first,
                                         AccessPhase phase) {
  const auto located = locate(dictionary, index, first);
  if (!located) return tl::unexpected(located.error());
  bool any = false;
  bool now = false;
  for (const auto& row : *located) {
    if (row.subindex < first) continue;
    any = any || can_write(row);
    now = now || (row.access & write_access(phase)) != 0;
  }
  if (!any) return tl::unexpected(SdoAbort::kReadOnly);
  if (!now) return tl::unexpected(SdoAbort::kDeviceState);
  return complete_size(*located, first);
}

SdoResult<void> download_complete(ObjectDictionary& dictionary, std::uint16_t index, std::uint8_t first,
                                  AccessPhase phase, std::span<const std::byte> data, DictionaryOwner& owner) {
  const auto most = writable_complete(dictionary, index, first, phase);
  if (!most) return tl::unexpected(most.error());
  if (data.size() > *most) return tl::unexpected(SdoAbort::kLengthTooHigh);
  const auto rows = dictionary.table().object(index);
  const auto* count = count_row(rows);
  if (first != 0 || (count != nullptr && !can_write(*count))) count = nullptr;
  if (count != nullptr && data.empty()) return tl::unexpected(SdoAbort::kLengthTooLow);
  const auto last = count == nullptr ? last_subindex(dictionary, rows) : bytes::load_le<std::uint8_t>(data);
  if (data.size() < Layout(rows, first).bytes(last)) return tl::unexpected(SdoAbort::kLengthTooLow);
  Snapshot before(dictionary, rows);
  const auto written = Download{dictionary, rows, first, phase, data, owner}.write_all(count, last);
  if (!written) before.restore(owner);
  return written;
}

}  // namespace driveline::slaves
