#include "driveline/slaves/idn/idn_dictionary.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using wire::AlState;
using wire::SoeCommandState;
using wire::SoeElement;
using wire::SoeError;
using wire::SoeListHeader;
using Bytes = std::vector<std::byte>;

Bytes list_of(std::span<const std::byte> content, std::size_t capacity) {
  Bytes bytes(SoeListHeader::kSize + content.size());
  SoeListHeader{static_cast<std::uint16_t>(content.size()), static_cast<std::uint16_t>(capacity)}.encode(
      std::span(bytes).first<SoeListHeader::kSize>());
  std::copy(content.begin(), content.end(), bytes.begin() + SoeListHeader::kSize);
  return bytes;
}

SoeAnswer<Bytes> text_or(std::string_view text, SoeError none) {
  if (text.empty()) return tl::unexpected(none);
  return list_of(std::as_bytes(std::span(text)), text.size());
}

Bytes number_bytes(const IdnRow& row, std::uint64_t raw) {
  Bytes bytes(row.attribute.element_size());
  raw_to_bytes(raw, bytes);
  return bytes;
}

SoeAnswer<Bytes> number_or(const IdnRow& row, bool exists, double number, SoeError none) {
  if (!exists) return tl::unexpected(none);
  return number_bytes(row, raw_from_number(row.attribute, number));
}

Bytes word(std::uint16_t value) {
  const auto bytes = bytes::to_le_bytes(value);
  return {bytes.begin(), bytes.end()};
}

SoeAnswer<Bytes> state_of(const IdnRow& row, const IdnValues& values) {
  if (!row.attribute.command) return tl::unexpected(SoeError::kNoState);
  return word(static_cast<std::uint16_t>(values.get(Slot<IdnCommand>{row.slot}).state));
}

Bytes bytes_of(const wire::SoeAttribute& attribute) {
  Bytes bytes(wire::SoeAttribute::kSize);
  attribute.encode(std::span(bytes).first<wire::SoeAttribute::kSize>());
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

/// Phases 2, 3 and 4 are PREOP, SAFEOP and OP.
bool is_protected(const wire::SoeAttribute& attribute, AlState state) noexcept {
  return (state == AlState::kPreOp && attribute.pre_op_protected) ||
         (state == AlState::kSafeOp && attribute.safe_op_protected) ||
         (state == AlState::kOp && attribute.op_protected);
}

/// Extracts the content of a list from the received data.
SoeAnswer<std::span<const std::byte>> content_of(const IdnRow& row, std::span<const std::byte> data) {
  const auto header = SoeListHeader::decode(data);
  if (!header) return tl::unexpected(SoeError::kValueTooShort);
  const auto content = data.subspan(SoeListHeader::kSize);
  if (content.size() < header->length) return tl::unexpected(SoeError::kValueTooShort);
  if (content.size() > header->length || header->length > row.capacity) return tl::unexpected(SoeError::kValueTooLong);
  if (header->length % row.attribute.element_size() != 0) return tl::unexpected(SoeError::kValueInvalid);
  return content;
}

/// Returns the number if its length and limits are valid.
SoeAnswer<std::span<const std::byte>> number_of(const IdnRow& row, std::span<const std::byte> data) {
  const auto size = row.attribute.element_size();
  if (data.size() < size) return tl::unexpected(SoeError::kValueTooShort);
  if (data.size() > size) return tl::unexpected(SoeError::kValueTooLong);
  const auto number = number_from_raw(row.attribute, raw_from_bytes(row.attribute, data));
  if (!std::isfinite(number)) return tl::unexpected(SoeError::kValueInvalid);
  if (number < row.minimum) return tl::unexpected(SoeError::kValueTooSmall);
  if (number > row.maximum) return tl::unexpected(SoeError::kValueTooLarge);
  return data;
}

}  // namespace

IdnDictionary::IdnDictionary(const std::vector<const IdnTable*>& drives) {
  drives_.reserve(drives.size());
  for (const auto* table : drives) drives_.emplace_back(*table);
}

SoeAnswer<Bytes> IdnDictionary::read_element(const SoeAccess& access) {
  const auto& values = drives_[access.drive];
  const auto* row = values.table().find(access.idn);
  if (row == nullptr) return tl::unexpected(SoeError::kNoIdn);
  switch (access.element) {
    case SoeElement::kState:
      return state_of(*row, values);
    case SoeElement::kName:
      return text_or(row->name, SoeError::kNoName);
    case SoeElement::kAttribute:
      return bytes_of(attribute(access.drive, *row));
    case SoeElement::kUnit:
      return text_or(unit(access.drive, *row), SoeError::kNoUnit);
    case SoeElement::kMin:
      return number_or(*row, std::isfinite(row->minimum), row->minimum, SoeError::kNoMin);
    case SoeElement::kMax:
      return number_or(*row, std::isfinite(row->maximum), row->maximum, SoeError::kNoMax);
    case SoeElement::kValue:
      return value_of(access.drive, *row);
    case SoeElement::kDefault:
      return number_or(*row, row->has_default, row->initial, SoeError::kNoDefault);
  }
  return tl::unexpected(SoeError::kNoElement);
}

Bytes IdnDictionary::value_of(std::uint8_t drive, const IdnRow& row) const {
  const auto& values = drives_[drive];
  if (row.attribute.command) return word(values.get(Slot<IdnCommand>{row.slot}).order);
  if (!row.attribute.list) return number_bytes(row, number(drive, row));
  if (row.selection != IdnSelection::kNone) return list_of(values.table().selected(row.selection), row.capacity);
  return list_of(content(drive, row), row.capacity);
}

SoeAnswer<void> IdnDictionary::write_element(const SoeAccess& access, std::span<const std::byte> data) {
  const auto* row = drives_[access.drive].table().find(access.idn);
  if (row == nullptr) return tl::unexpected(SoeError::kNoIdn);
  if (access.element != SoeElement::kValue) return tl::unexpected(read_only(access.element));
  return write_value(*row, access, data);
}

SoeAnswer<void> IdnDictionary::write_value(const IdnRow& row, const SoeAccess& access,
                                           std::span<const std::byte> data) {
  if (is_read_only(row.attribute)) return tl::unexpected(SoeError::kValueReadOnly);
  if (is_protected(row.attribute, access.state)) return tl::unexpected(SoeError::kValueProtected);
  const auto value = row.attribute.list ? content_of(row, data) : number_of(row, data);
  if (!value) return tl::unexpected(value.error());
  if (auto checked = check_value(access.drive, row.idn, *value); !checked) return checked;
  if (row.attribute.command) return command(row, access.drive, bytes::load_le<std::uint16_t>(*value));
  if (row.attribute.list) {
    set_content(access.drive, row, *value);
  } else {
    set_number(access.drive, row, raw_from_bytes(row.attribute, *value));
  }
  written(access.drive, row.idn);
  return {};
}

SoeAnswer<void> IdnDictionary::command(const IdnRow& row, std::uint8_t drive, std::uint16_t order) {
  const Slot<IdnCommand> slot{row.slot};
  auto state = SoeCommandState::kNotSet;
  if (order != wire::kSoeCommandCancel) {
    if (order != wire::kSoeCommandStart) return tl::unexpected(SoeError::kValueInvalid);
    if (drives_[drive].get(slot).state == SoeCommandState::kInProgress) return tl::unexpected(SoeError::kCommandActive);
    if (auto started = start_command(drive, row.idn); !started) return started;
    state = SoeCommandState::kInProgress;
  }
  drives_[drive].set(slot, {order, state});
  return {};
}

void IdnDictionary::end_command(std::uint8_t drive, wire::Idn idn, SoeCommandState state) noexcept {
  if (!has_drive(drive)) return;
  auto& values = drives_[drive];
  const auto* row = values.table().find(idn);
  if (row == nullptr || !row->attribute.command) return;
  const Slot<IdnCommand> slot{row->slot};
  const auto command = values.get(slot);
  if (command.state != SoeCommandState::kInProgress) return;
  values.set(slot, {command.order, state});
  say({drive, SoeCommandChange{idn, state}});
}

void IdnDictionary::say(const SoeMessage& message) noexcept {
  messages_[(oldest_ + waiting_) % kMaxMessages] = message;
  if (waiting_ == kMaxMessages) {
    oldest_ = (oldest_ + 1) % kMaxMessages;
  } else {
    ++waiting_;
  }
}

std::optional<SoeMessage> IdnDictionary::next_message() {
  if (waiting_ == 0) return std::nullopt;
  const auto message = messages_[oldest_];
  oldest_ = (oldest_ + 1) % kMaxMessages;
  --waiting_;
  return message;
}

}  // namespace driveline::slaves
