#include "object_description.hpp"

#include <string>

namespace driveline::slaves::msd {
namespace {

/// Returns the raw little-endian value as hex digits, as in ESI files.
std::string hex(const EntryRow& row, double number) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const auto raw = raw_from_number(row.type, number);
  std::string text;
  for (std::size_t i = 0; i < byte_size(row.type); ++i) {
    const auto byte = static_cast<std::uint8_t>(raw >> (8 * i));
    text += kDigits[byte >> 4];
    text += kDigits[byte & 0xFU];
  }
  return text;
}

esi::ObjectEntry describe(const EntryRow& row) {
  esi::ObjectEntry entry;
  entry.subindex = row.subindex;
  entry.name = entry_name(row);
  entry.type = row.type;
  entry.bit_length = static_cast<std::uint16_t>(8 * byte_size(row));
  entry.readable = (row.access & access::kRead) != 0;
  entry.writable = (row.access & access::kWrite) != 0;
  entry.rx_mappable = (row.access & access::kRxMappable) != 0;
  entry.tx_mappable = (row.access & access::kTxMappable) != 0;
  if (is_string(row.type)) return entry;
  entry.default_hex = hex(row, row.initial);
  if (row.minimum > -1e300) entry.minimum_hex = hex(row, row.minimum);
  if (row.maximum < 1e300) entry.maximum_hex = hex(row, row.maximum);
  return entry;
}

}  // namespace

std::vector<esi::Object> describe_objects(const DictionaryTable& table) {
  std::vector<esi::Object> objects;
  for (auto rows = table.next_object(0); !rows.empty(); rows = table.next_object(rows.front().index)) {
    esi::Object object{rows.front().index, std::string(rows.front().name), rows.front().code, {}};
    for (const auto& row : rows) object.entries.push_back(describe(row));
    objects.push_back(std::move(object));
  }
  return objects;
}

}  // namespace driveline::slaves::msd
