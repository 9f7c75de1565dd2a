#include "text/object_text.hpp"

#include <fmt/format.h>

#include "text/value_json.hpp"

namespace driveline::cli {
namespace {

using ecat_master::EntryDescription;
namespace access = wire::entry_access;

std::string access_text(std::uint16_t bits) {
  std::string text;
  constexpr std::array<std::pair<std::uint16_t, char>, 6> kRights = {{{access::kReadPreOp, 'r'},
                                                                      {access::kWritePreOp, 'w'},
                                                                      {access::kReadSafeOp, 'r'},
                                                                      {access::kWriteSafeOp, 'w'},
                                                                      {access::kReadOp, 'r'},
                                                                      {access::kWriteOp, 'w'}}};
  for (const auto& [bit, letter] : kRights) text += (bits & bit) != 0 ? letter : '-';
  return text;
}

std::string type_text(std::uint16_t data_type) {
  const auto type = runtime::value_type_of(data_type);
  return type ? std::string(runtime::type_name(*type)) : fmt::format("type {:04x}", data_type);
}

std::string value_text(const EntryDescription& entry, const std::vector<std::byte>& value) {
  const auto typed =
      runtime::format_value(value, runtime::value_type_of(entry.data_type).value_or(runtime::ValueType::kRaw));
  return typed ? *typed : runtime::format_value(value, runtime::ValueType::kRaw).value();
}

std::string facts_text(const EntryDescription& entry) {
  std::string text;
  const auto add = [&](std::string_view name, const std::optional<std::vector<std::byte>>& value) {
    if (value) text += fmt::format(", {} {}", name, value_text(entry, *value));
  };
  add("default", entry.default_value);
  add("minimum", entry.minimum);
  add("maximum", entry.maximum);
  if (entry.unit) text += fmt::format(", unit 0x{:08x}", *entry.unit);
  if ((entry.access & access::kRxMappable) != 0) text += ", RxPDO";
  if ((entry.access & access::kTxMappable) != 0) text += ", TxPDO";
  if ((entry.access & access::kBackup) != 0) text += ", backup";
  return text;
}

nlohmann::json value_json(const EntryDescription& entry, const std::optional<std::vector<std::byte>>& value) {
  if (!value) return nullptr;
  const auto typed = json_value(*value, runtime::value_type_of(entry.data_type).value_or(runtime::ValueType::kRaw));
  return typed ? *typed : json_value(*value, runtime::ValueType::kRaw).value();
}

nlohmann::json entry_json(const EntryDescription& entry) {
  nlohmann::json row = {{"subindex", entry.subindex},
                        {"access", access_text(entry.access)},
                        {"data_type", entry.data_type},
                        {"type", type_text(entry.data_type)},
                        {"bits", entry.bit_length},
                        {"name", entry.name},
                        {"rx_mappable", (entry.access & access::kRxMappable) != 0},
                        {"tx_mappable", (entry.access & access::kTxMappable) != 0},
                        {"backup", (entry.access & access::kBackup) != 0},
                        {"default", value_json(entry, entry.default_value)},
                        {"minimum", value_json(entry, entry.minimum)},
                        {"maximum", value_json(entry, entry.maximum)}};
  row["unit"] = entry.unit ? nlohmann::json(*entry.unit) : nlohmann::json();
  return row;
}

}  // namespace

std::string to_text(std::span<const DictionaryObject> objects, bool verbose) {
  std::string text;
  for (const auto& [object, entries, troubles] : objects) {
    text += fmt::format("SDO 0x{:04x}, \"{}\"\n", object.index, object.name);
    for (const auto& trouble : troubles) text += fmt::format("  ! {}\n", trouble);
    for (const auto& entry : entries) {
      text += fmt::format("  0x{:04x}:{:02x}, {}, {}, {} bit, \"{}\"{}\n", entry.index, entry.subindex,
                          access_text(entry.access), type_text(entry.data_type), entry.bit_length, entry.name,
                          verbose ? facts_text(entry) : "");
    }
  }
  return text;
}

nlohmann::json to_json(std::span<const DictionaryObject> objects) {
  auto rows = nlohmann::json::array();
  for (const auto& [object, entries, troubles] : objects) {
    auto list = nlohmann::json::array();
    for (const auto& entry : entries) list.push_back(entry_json(entry));
    rows.push_back(
        {{"index", object.index}, {"name", object.name}, {"code", object.object_code}, {"entries", std::move(list)}});
    if (!troubles.empty()) rows.back()["troubles"] = troubles;
  }
  return rows;
}

}  // namespace driveline::cli
