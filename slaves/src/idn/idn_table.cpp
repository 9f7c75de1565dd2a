#include "driveline/slaves/idn/idn_table.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "driveline/bytes/endian.hpp"

namespace driveline::slaves {
namespace {

/// Bits of a raw number that choose the parameter set; only set 0 exists (SERCOS manual 229).
constexpr std::uint16_t kParameterSet = 0x7000;
constexpr std::uint16_t kProduct = 0x8000;
constexpr std::uint16_t kBlockNumber = 0x0FFF;
/// Length codes of numbers of two and four bytes.
constexpr unsigned kTwoBytes = 1;
constexpr unsigned kFourBytes = 2;
constexpr std::array kSelections = {IdnSelection::kNone, IdnSelection::kAll, IdnSelection::kCommands,
                                    IdnSelection::kAt,   IdnSelection::kMdt, IdnSelection::kSaved};

[[noreturn]] void refuse(const IdnRow& row, const std::string& reason) {
  const auto idn = row.idn.text();
  throw std::logic_error(std::string(idn.data(), idn.size()) + ": " + reason);
}

void check(const IdnRow& row) {
  if ((row.idn.raw & kParameterSet) != 0) refuse(row, "only parameter set 0 exists");
  if (row.selection != IdnSelection::kNone && !is_read_only(row.attribute)) refuse(row, "follows from the table");
  if (row.attribute.list) {
    if (row.text.size() > row.capacity || 2 * row.elements.size() > row.capacity)
      refuse(row, "is longer than its list");
    return;
  }
  if (row.attribute.length_code > kFourBytes) refuse(row, "has more than four bytes");
  if (row.attribute.command && row.attribute.length_code != kTwoBytes) refuse(row, "is a command without two bytes");
  if (row.initial < row.minimum || row.initial > row.maximum) refuse(row, "starts outside its limits");
}

bool is_selected(const IdnRow& row, IdnSelection selection) noexcept {
  switch (selection) {
    case IdnSelection::kAll:
      return true;
    case IdnSelection::kCommands:
      return row.attribute.command;
    case IdnSelection::kAt:
      return (row.uses & idn_use::kAt) != 0;
    case IdnSelection::kMdt:
      return (row.uses & idn_use::kMdt) != 0;
    case IdnSelection::kSaved:
      return (row.uses & idn_use::kSaved) != 0;
    case IdnSelection::kNone:
      break;
  }
  return false;
}

}  // namespace

IdnTable::IdnTable(std::initializer_list<std::span<const IdnRow>> parts, std::uint16_t fixed_slots) {
  for (const auto& part : parts) rows_.insert(rows_.end(), part.begin(), part.end());
  std::sort(rows_.begin(), rows_.end(), [](const auto& a, const auto& b) { return a.idn.raw < b.idn.raw; });
  for (const auto& row : rows_) check(row);
  make_index();
  make_selections();
  assign_slots(fixed_slots);
  check_aliases();
}

void IdnTable::make_index() {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const auto raw = rows_[i].idn.raw;
    auto& index = (raw & kProduct) != 0 ? product_ : standard_;
    const std::size_t number = raw & kBlockNumber;
    if (number < index.size()) refuse(rows_[i], "has two rows");
    index.resize(number + 1);
    index[number] = static_cast<std::uint16_t>(i + 1);
  }
}

void IdnTable::make_selections() {
  for (const auto selection : kSelections) {
    auto& list = selections_.emplace_back();
    for (const auto& row : rows_) {
      if (!is_selected(row, selection)) continue;
      const auto bytes = bytes::to_le_bytes(row.idn.raw);
      list.insert(list.end(), bytes.begin(), bytes.end());
    }
  }
  for (auto& row : rows_) {
    if (row.selection != IdnSelection::kNone) row.capacity = static_cast<std::uint16_t>(selected(row.selection).size());
  }
}

void IdnTable::assign_slots(std::uint16_t fixed_slots) {
  places_.resize(fixed_slots);
  for (auto& row : rows_) {
    if (row.slot == IdnRow::kOwnSlot) {
      row.slot = slot_count();
      places_.emplace_back();
    } else if (row.slot >= fixed_slots) {
      refuse(row, "has a slot that does not exist");
    }
    auto& place = places_[row.slot];
    if (!row.attribute.list || row.selection != IdnSelection::kNone || place.capacity != 0) continue;
    place = {static_cast<std::uint32_t>(list_bytes_), row.capacity};
    list_bytes_ += row.capacity;
  }
}

void IdnTable::check_aliases() const {
  std::vector<const IdnRow*> first(slot_count());
  for (const auto& row : rows_) {
    auto& other = first[row.slot];
    if (other == nullptr) other = &row;
    const auto& a = row.attribute;
    const auto& b = other->attribute;
    const bool same = a.length_code == b.length_code && a.list == b.list && a.command == b.command &&
                      a.display == b.display && row.initial == other->initial && row.capacity == other->capacity;
    if (!same) refuse(row, "shares its value with an IDN of another type or initial value");
  }
}

const IdnRow* IdnTable::find(wire::Idn idn) const noexcept {
  const auto& index = (idn.raw & kProduct) != 0 ? product_ : standard_;
  const std::size_t number = idn.raw & kBlockNumber;
  if ((idn.raw & kParameterSet) != 0 || number >= index.size() || index[number] == 0) return nullptr;
  return &rows_[index[number] - 1U];
}

std::span<const std::byte> IdnTable::selected(IdnSelection selection) const noexcept {
  return selections_[static_cast<std::size_t>(selection)];
}

}  // namespace driveline::slaves
