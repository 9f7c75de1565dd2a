#include "persona/eeprom_edit.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

using Bytes = std::span<std::byte>;
using Kind = PersonaKind;

// Layout of the EEPROM (ETG.1000.6 5.4): a fixed part, then categories of type, length in words and content.
constexpr std::size_t kMailboxAddresses = 0x30;  ///< standard mailboxes: receive and send, offset and size
constexpr std::size_t kMailboxAddressBytes = 8;
constexpr std::size_t kFirstCategory = 0x80;
constexpr std::size_t kCategoryHeader = 4;
constexpr std::uint16_t kSyncManagers = 41;
constexpr std::uint16_t kTxPdo = 50;
constexpr std::uint16_t kRxPdo = 51;
constexpr std::uint16_t kEnd = 0xFFFF;
/// Content of an erased EEPROM.
constexpr std::byte kErased{0xFF};

// Element of category 41 (Table 23).
constexpr std::size_t kSyncManagerBytes = 8;
constexpr std::size_t kEnableAt = 6;
constexpr std::size_t kTypeAt = 7;
constexpr std::byte kOutputs{3};
constexpr std::byte kInputs{4};

// Categories 50 and 51 (Table 24): PDOs with their entries, each with the number of a string.
constexpr std::size_t kPdoBytes = 8;
constexpr std::size_t kEntryCountAt = 2;
constexpr std::size_t kPdoNameAt = 5;
constexpr std::size_t kEntryBytes = 8;
constexpr std::size_t kEntryNameAt = 3;

/// A category in the content.
struct Category {
  std::uint16_t type = kEnd;
  std::size_t begin = 0;  ///< offset of its type
  std::size_t end = 0;    ///< offset of the next category
};

/// Returns the category at `offset`; kEnd behind the last one.
Category category_at(std::span<const std::byte> image, std::size_t offset) noexcept {
  if (offset + kCategoryHeader > image.size()) return {};
  const auto type = bytes::load_le<std::uint16_t>(image.subspan(offset));
  const std::size_t bytes = 2 * std::size_t{bytes::load_le<std::uint16_t>(image.subspan(offset + 2))};
  const auto end = std::min(offset + kCategoryHeader + bytes, image.size());
  return {type, offset, end};
}

/// Calls `edit` with the content of each category of this type.
template <typename Edit>
void edit_categories(Bytes image, std::uint16_t type, Edit edit) {
  for (auto at = category_at(image, kFirstCategory); at.type != kEnd; at = category_at(image, at.end)) {
    if (at.type == type) edit(image.subspan(at.begin + kCategoryHeader, at.end - at.begin - kCategoryHeader));
  }
}

/// Calls `edit` with each sync manager.
template <typename Edit>
void edit_sync_managers(Bytes image, Edit edit) {
  edit_categories(image, kSyncManagers, [&edit](Bytes content) {
    for (std::size_t at = 0; at + kSyncManagerBytes <= content.size(); at += kSyncManagerBytes) {
      edit(content.subspan(at, kSyncManagerBytes));
    }
  });
}

void swap_types(Bytes sync_manager) noexcept {
  auto& type = sync_manager[kTypeAt];
  if (type == kOutputs) {
    type = kInputs;
  } else if (type == kInputs) {
    type = kOutputs;
  }
}

void disable(Bytes sync_manager) noexcept {
  const auto type = sync_manager[kTypeAt];
  if (type == kOutputs || type == kInputs) sync_manager[kEnableAt] = std::byte{0};
}

void remove_names(Bytes pdos) noexcept {
  std::size_t at = 0;
  while (at + kPdoBytes <= pdos.size()) {
    pdos[at + kPdoNameAt] = std::byte{0};
    const auto entries = std::to_integer<std::size_t>(pdos[at + kEntryCountAt]);
    at += kPdoBytes;
    for (std::size_t i = 0; i < entries && at + kEntryBytes <= pdos.size(); ++i, at += kEntryBytes) {
      pdos[at + kEntryNameAt] = std::byte{0};
    }
  }
}

/// Removes the categories of these types; the following ones move up.
void remove_categories(std::vector<std::byte>& image, std::span<const std::uint16_t> types) {
  const auto size = image.size();
  for (auto at = category_at(image, kFirstCategory); at.type != kEnd;) {
    const bool remove = std::find(types.begin(), types.end(), at.type) != types.end();
    const auto begin = image.begin();
    if (remove) image.erase(begin + static_cast<std::ptrdiff_t>(at.begin), begin + static_cast<std::ptrdiff_t>(at.end));
    at = category_at(image, remove ? at.begin : at.end);
  }
  image.resize(size, kErased);
}

void erase_categories(Bytes image) noexcept {
  if (image.size() > kFirstCategory) std::fill(image.begin() + kFirstCategory, image.end(), kErased);
}

void erase_mailbox(Bytes image) noexcept {
  if (image.size() < kMailboxAddresses + kMailboxAddressBytes) return;
  const auto addresses = image.subspan(kMailboxAddresses, kMailboxAddressBytes);
  std::fill(addresses.begin(), addresses.end(), std::byte{0});
}

}  // namespace

void edit_eeprom(std::span<const Persona> personas, std::vector<std::byte>& image) {
  constexpr std::array kPdos = {kTxPdo, kRxPdo};
  if (has_persona(personas, Kind::kEepromDisabled)) edit_sync_managers(image, disable);
  if (has_persona(personas, Kind::kEepromTypesSwapped)) edit_sync_managers(image, swap_types);
  if (has_persona(personas, Kind::kEepromTypesZero)) {
    edit_sync_managers(image, [](Bytes sync_manager) { sync_manager[kTypeAt] = std::byte{0}; });
  }
  if (has_persona(personas, Kind::kEepromWithoutNames)) {
    for (const auto type : kPdos) edit_categories(image, type, remove_names);
  }
  if (has_persona(personas, Kind::kEepromWithoutPdos)) remove_categories(image, kPdos);
  if (has_persona(personas, Kind::kEepromWithoutCategories)) erase_categories(image);
  if (has_persona(personas, Kind::kEepromWithoutMailbox)) erase_mailbox(image);
}

}  // namespace driveline::slaves
