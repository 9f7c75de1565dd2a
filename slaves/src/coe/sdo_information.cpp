#include "driveline/slaves/coe/sdo_information.hpp"

#include <algorithm>

#include "driveline/slaves/coe/coe_access.hpp"

namespace driveline::slaves {
namespace {

using wire::SdoAbort;
using wire::SdoInfoHeader;
using wire::SdoInfoOpCode;

/// Object lists of the service (ETG.1000.6 Table 47): list 0 contains the lengths of the other lists.
enum class ListType : std::uint16_t { kLengths = 0, kAll, kRxMappable, kTxMappable, kBackup, kStartUp };
constexpr std::uint16_t kLastListType = static_cast<std::uint16_t>(ListType::kStartUp);

/// Value information bits of an entry description (ETG.1000.6 Table 53).
constexpr std::uint8_t kAlwaysThere = 0x07;  ///< access rights, category, mappability: part of every response
constexpr std::uint8_t kDefaultValue = 0x10;
constexpr std::uint8_t kMinimum = 0x20;
constexpr std::uint8_t kMaximum = 0x40;

/// Appends to a span; ignores data after its end.
class Writer {
 public:
  explicit Writer(std::span<std::byte> out) noexcept : out_(out) {}
  template <bytes::Integer T>
  void put(T value) noexcept {
    if (out_.size() - used_ < sizeof(T)) return;
    bytes::store_le(out_.subspan(used_), value);
    used_ += sizeof(T);
  }
  void put(std::string_view text) noexcept {
    for (const char c : text.substr(0, out_.size() - used_)) out_[used_++] = static_cast<std::byte>(c);
  }
  void put_value(const EntryRow& row, std::uint64_t raw) noexcept {
    for (std::size_t i = 0; i < byte_size(row.type); ++i) put(static_cast<std::uint8_t>(raw >> (8 * i)));
  }
  [[nodiscard]] std::size_t used() const noexcept { return used_; }

 private:
  std::span<std::byte> out_;
  std::size_t used_ = 0;
};

void put_header(SdoInfoOpCode op, std::size_t fragments_left, std::span<std::byte> out) noexcept {
  SdoInfoHeader{op, fragments_left != 0, static_cast<std::uint16_t>(fragments_left)}.encode(
      out.first<SdoInfoHeader::kSize>());
}

std::size_t error(SdoAbort code, std::span<std::byte> out) noexcept {
  put_header(SdoInfoOpCode::kError, 0, out);
  bytes::store_le(out.subspan(SdoInfoHeader::kSize), static_cast<std::uint32_t>(code));
  return SdoInfoHeader::kSize + 4;
}

bool belongs_to(ListType type, std::span<const EntryRow> rows) noexcept {
  std::uint16_t wanted = 0;
  switch (type) {
    case ListType::kAll:
      return true;
    case ListType::kRxMappable:
      wanted = access::kRxMappable;
      break;
    case ListType::kTxMappable:
      wanted = access::kTxMappable;
      break;
    case ListType::kBackup:
      wanted = access::kBackup;
      break;
    default:
      return false;  // no object needs a start-up parameter
  }
  return std::any_of(rows.begin(), rows.end(), [wanted](const EntryRow& row) { return (row.access & wanted) != 0; });
}

std::uint16_t data_type_of(std::span<const EntryRow> rows) noexcept {
  const EntryRow& first = rows.front();
  if (first.record_type != 0) return first.record_type;
  const bool array = first.code == esi::ObjectCode::kArray && rows.size() > 1;
  return static_cast<std::uint16_t>(array ? rows[1].type : first.type);
}

}  // namespace

SdoInformation::SdoInformation(const ObjectDictionary& dictionary) : dictionary_(&dictionary) {
  list_.reserve(2 * (dictionary.table().rows().size() + 1));
}

void SdoInformation::cancel() noexcept {
  list_.clear();
  sent_ = 0;
}

std::size_t SdoInformation::handle(std::span<const std::byte> request, std::span<std::byte> out) {
  cancel();
  const auto header = SdoInfoHeader::decode(request);
  if (!header) return error(SdoAbort::kInvalidCommand, out);
  const auto data = request.subspan(SdoInfoHeader::kSize);
  switch (header->op_code) {
    case SdoInfoOpCode::kListRequest:
      if (data.size() < 2) break;
      return list(bytes::load_le<std::uint16_t>(data), out);
    case SdoInfoOpCode::kObjectRequest:
      if (data.size() < 2) break;
      return object(bytes::load_le<std::uint16_t>(data), out);
    case SdoInfoOpCode::kEntryRequest:
      if (data.size() < 4) break;
      return entry(bytes::load_le<std::uint16_t>(data), bytes::load_le<std::uint8_t>(data.subspan(2)),
                   bytes::load_le<std::uint8_t>(data.subspan(3)), out);
    default:
      break;
  }
  return error(SdoAbort::kInvalidCommand, out);
}

void SdoInformation::collect(std::uint16_t type) {
  const auto append = [this](std::uint16_t value) {
    const auto bytes = bytes::to_le_bytes(value);
    list_.insert(list_.end(), bytes.begin(), bytes.end());
  };
  append(type);
  std::array<std::uint16_t, kLastListType + 1> lengths{};
  const auto& table = dictionary_->table();
  for (auto rows = table.next_object(0); !rows.empty(); rows = table.next_object(rows.front().index)) {
    for (std::uint16_t t = 1; t <= kLastListType; ++t) {
      if (!belongs_to(static_cast<ListType>(t), rows)) continue;
      ++lengths[t];
      if (t == type) append(rows.front().index);
    }
  }
  if (type != static_cast<std::uint16_t>(ListType::kLengths)) return;
  for (std::uint16_t t = 1; t <= kLastListType; ++t) append(lengths[t]);
}

std::size_t SdoInformation::list(std::uint16_t type, std::span<std::byte> out) {
  if (type > kLastListType) return error(SdoAbort::kUnsupportedAccess, out);
  collect(type);
  return next_fragment(out);
}

std::size_t SdoInformation::next_fragment(std::span<std::byte> out) {
  if (sent_ == list_.size()) return 0;
  const std::size_t room = (out.size() - SdoInfoHeader::kSize) & ~std::size_t{1};
  const std::size_t left = list_.size() - sent_;
  const std::size_t count = std::min(room, left);
  put_header(SdoInfoOpCode::kListResponse, (left - count + room - 1) / room, out);
  std::copy_n(list_.begin() + static_cast<std::ptrdiff_t>(sent_), count, out.begin() + SdoInfoHeader::kSize);
  sent_ += count;
  return SdoInfoHeader::kSize + count;
}

std::size_t SdoInformation::object(std::uint16_t index, std::span<std::byte> out) const {
  const auto rows = dictionary_->table().object(index);
  if (rows.empty()) return error(SdoAbort::kObjectDoesNotExist, out);
  put_header(SdoInfoOpCode::kObjectResponse, 0, out);
  Writer writer(out.subspan(SdoInfoHeader::kSize));
  writer.put(index);
  writer.put(data_type_of(rows));
  writer.put(rows.back().subindex);
  writer.put(static_cast<std::uint8_t>(rows.front().code));
  writer.put(rows.front().name);
  return SdoInfoHeader::kSize + writer.used();
}

std::size_t SdoInformation::entry(std::uint16_t index, std::uint8_t subindex, std::uint8_t wanted,
                                  std::span<std::byte> out) const {
  if (dictionary_->table().object(index).empty()) return error(SdoAbort::kObjectDoesNotExist, out);
  const auto* row = dictionary_->table().find(index, subindex);
  if (row == nullptr) return error(SdoAbort::kSubindexDoesNotExist, out);
  const bool number = !is_string(row->type);
  auto included = static_cast<std::uint8_t>(wanted & kAlwaysThere);
  if (number) included |= wanted & kDefaultValue;
  if (number && row->minimum > -1e300) included |= wanted & kMinimum;
  if (number && row->maximum < 1e300) included |= wanted & kMaximum;

  put_header(SdoInfoOpCode::kEntryResponse, 0, out);
  Writer writer(out.subspan(SdoInfoHeader::kSize));
  writer.put(index);
  writer.put(subindex);
  writer.put(included);
  writer.put(static_cast<std::uint16_t>(row->type));
  writer.put(static_cast<std::uint16_t>(bit_size(*row)));
  writer.put(coe_access(*row));
  if ((included & kDefaultValue) != 0) writer.put_value(*row, initial_raw(*row));
  if ((included & kMinimum) != 0) writer.put_value(*row, raw_from_number(row->type, row->minimum));
  if ((included & kMaximum) != 0) writer.put_value(*row, raw_from_number(row->type, row->maximum));
  writer.put(entry_name(*row));
  return SdoInfoHeader::kSize + writer.used();
}

}  // namespace driveline::slaves
