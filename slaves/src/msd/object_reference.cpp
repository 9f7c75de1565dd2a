// Reference page of the object dictionary, made from the table.
#include <array>
#include <charconv>

#include "driveline/slaves/msd/msd_table.hpp"

namespace driveline::slaves::msd {
namespace {

std::string hex(unsigned value, int digits) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text;
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
    text += kDigits[value >> static_cast<unsigned>(shift) & 0xFU];
  return text;
}

/// Formats a number, short and exact; limits of the data type itself stay empty.
std::string number(double value) {
  if (value >= 1e300 || value <= -1e300) return {};
  std::array<char, 32> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 10).ptr;
  return {buffer.data(), end};
}

std::string_view type_name(esi::DataType type) {
  switch (type) {
    case esi::DataType::kBoolean:
      return "BOOL";
    case esi::DataType::kInteger8:
      return "I8";
    case esi::DataType::kInteger16:
      return "I16";
    case esi::DataType::kInteger32:
      return "I32";
    case esi::DataType::kUnsigned8:
      return "U8";
    case esi::DataType::kUnsigned16:
      return "U16";
    case esi::DataType::kUnsigned32:
      return "U32";
    case esi::DataType::kReal32:
      return "REAL32";
    case esi::DataType::kVisibleString:
      return "STRING";
    default:
      return "other";
  }
}

std::string access_text(const EntryRow& row) {
  std::string text = (row.access & access::kWrite) == 0                ? "ro"
                     : (row.access & access::kWrite) == access::kWrite ? "rw"
                                                                       : "rw in PREOP";
  if (row.power_off_only) text += ", power off";
  if ((row.access & access::kRxMappable) != 0) text += ", RxPDO";
  if ((row.access & access::kTxMappable) != 0) text += ", TxPDO";
  if ((row.access & access::kBackup) != 0) text += ", stored";
  return text;
}

std::string range_text(const EntryRow& row) {
  const auto low = number(row.minimum);
  const auto high = number(row.maximum);
  return low.empty() && high.empty() ? std::string{} : low + " ... " + high;
}

}  // namespace

std::string object_reference(Variant variant) {
  std::string text =
      "# Objects of the simulated " + std::string(variant == Variant::kMsd ? "MSD" : "ServoOne") + "\n\n";
  text +=
      "Made from the drive's object dictionary table, like the ESI file, by `driveline esi generate`. Objects 2000h + "
      "n are the\n"
      "P-parameters n. *Source* tells where a row comes from; \"ours\" marks what no source states.\n\n"
      "| object | name | type | access | default | range | unit | source |\n|---|---|---|---|---|---|---|---|\n";
  for (const auto& row : dictionary_table(variant).rows()) {
    const bool parameter = row.index >= 0x2000 && row.index < 0x6000;
    text += "| " + hex(row.index, 4) + "h:" + hex(row.subindex, 2) + " | ";
    if (parameter) text += "P " + std::to_string(row.index - 0x2000) + " ";
    text += std::string(entry_name(row)) + " | " + std::string(type_name(row.type)) + " | " + access_text(row) + " | " +
            (is_string(row.type) ? std::string(row.text) : number(row.initial)) + " | " + range_text(row) + " | " +
            std::string(row.unit) + " | " + std::string(row.source) + " |\n";
  }
  return text;
}

}  // namespace driveline::slaves::msd
