#include "driveline/slaves/pdo/pdo_settings.hpp"

#include <algorithm>
#include <array>

namespace driveline::slaves {
namespace {

/// Objects of profiles begin here; below it are the parameters of the device.
constexpr std::uint16_t kFirstProfileObject = 0x6000;
constexpr std::size_t kMostFields = 64;

bool is_setting(const PdoMap::Field& field) noexcept {
  return field.is_number() && (field.row->access & access::kBackup) != 0;
}

}  // namespace

bool has_settings(const PdoMap& map) noexcept {
  const auto fields = map.fields();
  return std::any_of(fields.begin(), fields.end(), is_setting);
}

void decode_settings(const PdoMap& map, std::span<const std::byte> data, ObjectDictionary& dictionary,
                     DictionaryOwner& owner) noexcept {
  const auto fields = map.fields().first(std::min(map.fields().size(), kMostFields));
  std::array<std::uint64_t, kMostFields> before{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (is_setting(fields[i])) before[i] = dictionary.raw(fields[i].slot);
  }
  map.decode(data, dictionary);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const EntryRow& row = *fields[i].row;
    if (!is_setting(fields[i]) || dictionary.raw(row.slot) == before[i]) continue;
    const std::uint64_t raw = dictionary.raw(row.slot);
    const bool parameter = row.index < kFirstProfileObject;
    const bool refused = parameter && (!check_range(row, raw) || !owner.accept(row, raw));
    if (refused) dictionary.set_raw(row.slot, before[i]);
    if (!refused) owner.written(row);
  }
}

}  // namespace driveline::slaves
