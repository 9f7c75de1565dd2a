#include "driveline/slaves/mailbox/soe_table.hpp"

#include <algorithm>
#include <utility>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::AlState;
using wire::SoeCommandState;
using wire::SoeDisplay;
using wire::SoeElement;
using wire::SoeError;
using wire::SoeListHeader;
using Bytes = std::vector<std::byte>;

constexpr wire::Idn kListOfAll{17};

void append(Bytes& bytes, std::span<const std::byte> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

Bytes list_of(std::span<const std::byte> content, std::size_t capacity) {
  Bytes bytes(SoeListHeader::kSize + content.size());
  SoeListHeader{static_cast<std::uint16_t>(content.size()), static_cast<std::uint16_t>(capacity)}.encode(
      std::span(bytes).first<SoeListHeader::kSize>());
  std::copy(content.begin(), content.end(), bytes.begin() + SoeListHeader::kSize);
  return bytes;
}

SoeAnswer<Bytes> text_or(const std::string& text, SoeError none) {
  if (text.empty()) return tl::unexpected(none);
  return list_of(std::as_bytes(std::span(text)), text.size());
}

SoeAnswer<Bytes> bytes_or(const Bytes& bytes, SoeError none) {
  if (bytes.empty()) return tl::unexpected(none);
  return bytes;
}

/// Returns the error code for a write to an element other than the value.
SoeError read_only(SoeElement element) noexcept {
  switch (element) {
    case SoeElement::kName:
      return SoeError::kNameReadOnly;
    case SoeElement::kAttribute:
      return SoeError::kAttributeReadOnly;
    case SoeElement::kUnit:
      return SoeError::kUnitReadOnly;
    case SoeElement::kMin:
      return SoeError::kMinReadOnly;
    case SoeElement::kMax:
      return SoeError::kMaxReadOnly;
    case SoeElement::kDefault:
      return SoeError::kDefaultReadOnly;
    default:
      return SoeError::kWrongAccess;
  }
}

bool is_protected(const wire::SoeAttribute& attribute, AlState state) noexcept {
  return (state == AlState::kPreOp && attribute.pre_op_protected) ||
         (state == AlState::kSafeOp && attribute.safe_op_protected) ||
         (state == AlState::kOp && attribute.op_protected);
}

bool is_read_only(const wire::SoeAttribute& attribute) noexcept {
  return attribute.pre_op_protected && attribute.safe_op_protected && attribute.op_protected;
}

/// Whether `a` is less than `b`; both have the length of the value.
bool less(std::span<const std::byte> a, std::span<const std::byte> b, bool with_sign) noexcept {
  const auto number = [with_sign](std::span<const std::byte> bytes) {
    const bool negative = with_sign && (bytes.back() & std::byte{0x80}) != std::byte{0};
    std::uint64_t value = negative ? ~std::uint64_t{0} : 0;
    for (auto byte = bytes.rbegin(); byte != bytes.rend(); ++byte)
      value = value << 8 | std::to_integer<unsigned>(*byte);
    return value;
  };
  return with_sign ? static_cast<std::int64_t>(number(a)) < static_cast<std::int64_t>(number(b))
                   : number(a) < number(b);
}

/// Extracts the content of a list from the received data.
SoeAnswer<std::span<const std::byte>> content_of(const SoeRow& row, std::span<const std::byte> data) {
  const auto header = SoeListHeader::decode(data);
  if (!header) return tl::unexpected(SoeError::kValueTooShort);
  const auto content = data.subspan(SoeListHeader::kSize);
  if (content.size() < header->length) return tl::unexpected(SoeError::kValueTooShort);
  if (content.size() > header->length || header->length > row.capacity) return tl::unexpected(SoeError::kValueTooLong);
  if (header->length % row.attribute.element_size() != 0) return tl::unexpected(SoeError::kValueInvalid);
  return content;
}

/// Returns the number if its length and limits are valid.
SoeAnswer<std::span<const std::byte>> number_of(const SoeRow& row, std::span<const std::byte> data) {
  const auto size = row.attribute.element_size();
  if (data.size() < size) return tl::unexpected(SoeError::kValueTooShort);
  if (data.size() > size) return tl::unexpected(SoeError::kValueTooLong);
  const bool with_sign = row.attribute.display == SoeDisplay::kSigned;
  if (!row.min.empty() && less(data, row.min, with_sign)) return tl::unexpected(SoeError::kValueTooSmall);
  if (!row.max.empty() && less(row.max, data, with_sign)) return tl::unexpected(SoeError::kValueTooLarge);
  return data;
}

}  // namespace

SoeTable::SoeTable(std::vector<std::vector<SoeRow>> drives) : drives_(std::move(drives)) {
  for (auto& rows : drives_) {
    Bytes all;
    for (const auto& row : rows) append(all, bytes::to_le_bytes(row.idn.raw));
    const auto list = std::find_if(rows.begin(), rows.end(), [](const auto& row) { return row.idn == kListOfAll; });
    if (list != rows.end()) {
      list->capacity = static_cast<std::uint16_t>(all.size());
      list->value = std::move(all);
    }
    for (auto& row : rows) row.value.reserve(row.capacity);
  }
}

SoeRow* SoeTable::find(std::uint8_t drive, wire::Idn idn) noexcept {
  if (!has_drive(drive)) return nullptr;
  auto& rows = drives_[drive];
  const auto found = std::find_if(rows.begin(), rows.end(), [idn](const auto& row) { return row.idn == idn; });
  return found == rows.end() ? nullptr : &*found;
}

SoeAnswer<Bytes> SoeTable::read_element(const SoeAccess& access) {
  const auto* row = find(access.drive, access.idn);
  if (row == nullptr) return tl::unexpected(SoeError::kNoIdn);
  switch (access.element) {
    case SoeElement::kState: {
      if (!row->attribute.command) return tl::unexpected(SoeError::kNoState);
      const auto state = bytes::to_le_bytes(static_cast<std::uint16_t>(row->state));
      return Bytes(state.begin(), state.end());
    }
    case SoeElement::kName:
      return text_or(row->name, SoeError::kNoName);
    case SoeElement::kAttribute: {
      Bytes bytes(wire::SoeAttribute::kSize);
      row->attribute.encode(std::span(bytes).first<wire::SoeAttribute::kSize>());
      return bytes;
    }
    case SoeElement::kUnit:
      return text_or(row->unit, SoeError::kNoUnit);
    case SoeElement::kMin:
      return bytes_or(row->min, SoeError::kNoMin);
    case SoeElement::kMax:
      return bytes_or(row->max, SoeError::kNoMax);
    case SoeElement::kValue:
      return row->attribute.list ? list_of(row->value, row->capacity) : row->value;
    case SoeElement::kDefault:
      return bytes_or(row->preset, SoeError::kNoDefault);
  }
  return tl::unexpected(SoeError::kNoElement);
}

SoeAnswer<void> SoeTable::write_element(const SoeAccess& access, std::span<const std::byte> data) {
  auto* row = find(access.drive, access.idn);
  if (row == nullptr) return tl::unexpected(SoeError::kNoIdn);
  if (access.element != SoeElement::kValue) return tl::unexpected(read_only(access.element));
  return write_value(*row, access, data);
}

SoeAnswer<void> SoeTable::write_value(SoeRow& row, const SoeAccess& access, std::span<const std::byte> data) {
  if (is_read_only(row.attribute)) return tl::unexpected(SoeError::kValueReadOnly);
  if (is_protected(row.attribute, access.state)) return tl::unexpected(SoeError::kValueProtected);
  const auto value = row.attribute.list ? content_of(row, data) : number_of(row, data);
  if (!value) return tl::unexpected(value.error());
  if (auto checked = check_value(access.drive, row.idn, *value); !checked) return checked;
  if (row.attribute.command) return command(row, access.drive, *value);
  row.value.assign(value->begin(), value->end());
  return {};
}

SoeAnswer<void> SoeTable::command(SoeRow& row, std::uint8_t drive, std::span<const std::byte> data) {
  const auto order = bytes::load_le<std::uint16_t>(data);
  if (order == wire::kSoeCommandCancel) {
    row.state = SoeCommandState::kNotSet;
  } else if (order != wire::kSoeCommandStart) {
    return tl::unexpected(SoeError::kValueInvalid);
  } else if (row.state == SoeCommandState::kInProgress) {
    return tl::unexpected(SoeError::kCommandActive);
  } else if (auto started = start_command(drive, row.idn); !started) {
    return started;
  } else {
    row.state = SoeCommandState::kInProgress;
  }
  row.value.assign(data.begin(), data.end());
  return {};
}

void SoeTable::end_command(std::uint8_t drive, wire::Idn idn, SoeCommandState state) noexcept {
  auto* row = find(drive, idn);
  if (row == nullptr || row->state != SoeCommandState::kInProgress) return;
  row->state = state;
  say({drive, SoeCommandChange{idn, state}});
}

void SoeTable::say(const SoeMessage& message) noexcept {
  messages_[(oldest_ + waiting_) % kMaxMessages] = message;
  if (waiting_ == kMaxMessages) {
    oldest_ = (oldest_ + 1) % kMaxMessages;
  } else {
    ++waiting_;
  }
}

std::optional<SoeMessage> SoeTable::next_message() {
  if (waiting_ == 0) return std::nullopt;
  const auto message = messages_[oldest_];
  oldest_ = (oldest_ + 1) % kMaxMessages;
  --waiting_;
  return message;
}

}  // namespace driveline::slaves
