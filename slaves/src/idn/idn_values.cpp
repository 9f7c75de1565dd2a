#include "driveline/slaves/idn/idn_values.hpp"

#include <algorithm>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {

IdnValues::IdnValues(const IdnTable& table) : table_(&table), numbers_(table.slot_count()), lists_(table.list_bytes()) {
  for (const auto& row : table.rows()) {
    if (is_number(row)) {
      set_raw(row, raw_from_number(row.attribute, row.initial));
    } else if (!row.text.empty()) {
      set(Slot<IdnList>{row.slot}, std::as_bytes(std::span(row.text)));
    } else if (!row.elements.empty()) {
      std::vector<std::byte> content;
      for (const auto element : row.elements) {
        const auto bytes = bytes::to_le_bytes(element);
        content.insert(content.end(), bytes.begin(), bytes.end());
      }
      set(Slot<IdnList>{row.slot}, content);
    }
  }
}

std::span<const std::byte> IdnValues::get(Slot<IdnList> slot) const noexcept {
  return std::span(lists_).subspan(table_->place(slot.number).offset, numbers_[slot.number]);
}

void IdnValues::set(Slot<IdnList> slot, std::span<const std::byte> content) noexcept {
  const auto& place = table_->place(slot.number);
  const auto part = content.first(std::min<std::size_t>(content.size(), place.capacity));
  std::copy(part.begin(), part.end(), lists_.begin() + place.offset);
  numbers_[slot.number] = part.size();
}

IdnCommand IdnValues::get(Slot<IdnCommand> slot) const noexcept {
  const auto number = numbers_[slot.number];
  return {static_cast<std::uint16_t>(number), static_cast<wire::SoeCommandState>(number >> 16)};
}

void IdnValues::set(Slot<IdnCommand> slot, IdnCommand command) noexcept {
  numbers_[slot.number] = command.order | static_cast<std::uint64_t>(command.state) << 16;
}

std::uint64_t raw_from_bytes(const wire::SoeAttribute& attribute, std::span<const std::byte> bytes) noexcept {
  const bool negative = attribute.display == wire::SoeDisplay::kSigned && !bytes.empty() &&
                        (bytes.back() & std::byte{0x80}) != std::byte{0};
  std::uint64_t raw = negative ? ~std::uint64_t{0} : 0;
  for (auto byte = bytes.rbegin(); byte != bytes.rend(); ++byte) raw = raw << 8 | std::to_integer<unsigned>(*byte);
  return raw;
}

void raw_to_bytes(std::uint64_t raw, std::span<std::byte> out) noexcept {
  for (auto& byte : out) {
    byte = static_cast<std::byte>(raw & 0xFFU);
    raw >>= 8;
  }
}

double number_from_raw(const wire::SoeAttribute& attribute, std::uint64_t raw) noexcept {
  if (attribute.display == wire::SoeDisplay::kFloat) return std::bit_cast<float>(static_cast<std::uint32_t>(raw));
  if (attribute.display == wire::SoeDisplay::kSigned) return static_cast<double>(static_cast<std::int64_t>(raw));
  return static_cast<double>(raw);
}

std::uint64_t raw_from_number(const wire::SoeAttribute& attribute, double number) noexcept {
  if (attribute.display == wire::SoeDisplay::kFloat) return std::bit_cast<std::uint32_t>(static_cast<float>(number));
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(number));
}

}  // namespace driveline::slaves
