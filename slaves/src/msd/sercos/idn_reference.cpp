// Reference page of the ServoOne's IDNs, made from the table.
#include <array>
#include <charconv>
#include <cmath>

#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

namespace driveline::slaves::msd::sercos {
namespace {

std::string_view display_name(const wire::SoeAttribute& attribute) {
  switch (attribute.display) {
    case wire::SoeDisplay::kBinary:
      return "BIN";
    case wire::SoeDisplay::kSigned:
      return "I";
    case wire::SoeDisplay::kHexadecimal:
      return "HEX";
    case wire::SoeDisplay::kText:
      return "TEXT";
    case wire::SoeDisplay::kIdn:
      return "IDN";
    case wire::SoeDisplay::kFloat:
      return "REAL";
    default:
      return "U";
  }
}

std::string type_text(const IdnRow& row) {
  if (row.attribute.command) return "command";
  const auto& attribute = row.attribute;
  std::string text(display_name(attribute));
  const bool sized = attribute.display != wire::SoeDisplay::kText && attribute.display != wire::SoeDisplay::kIdn;
  if (sized) text += std::to_string(8 * attribute.element_size());
  if (attribute.decimals != 0) text += ", " + std::to_string(attribute.decimals) + " decimals";
  if (attribute.list) text += ", list of " + std::to_string(row.capacity / attribute.element_size());
  return text;
}

std::string number_text(double number) {
  if (!std::isfinite(number)) return {};
  std::array<char, 32> buffer{};
  const auto* end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, std::chars_format::general, 10).ptr;
  return {static_cast<const char*>(buffer.data()), end};
}

std::string range_text(const IdnRow& row) {
  const bool none = !std::isfinite(row.minimum) && !std::isfinite(row.maximum);
  return none ? std::string{} : number_text(row.minimum) + " ... " + number_text(row.maximum);
}

std::string phases_text(const wire::SoeAttribute& attribute) {
  if (is_read_only(attribute)) return "never";
  std::string text;
  if (!attribute.pre_op_protected) text += "2";
  if (!attribute.safe_op_protected) text += "3";
  if (!attribute.op_protected) text += "4";
  return text;
}

std::string uses_text(const IdnRow& row) {
  constexpr std::array kTexts = {std::pair{idn_use::kAt, "AT"}, std::pair{idn_use::kMdt, "MDT"},
                                 std::pair{idn_use::kSaved, "saved"},
                                 std::pair{idn_use::kStored, "stored, without effect"}};
  std::string text;
  for (const auto& [use, name] : kTexts) {
    if ((row.uses & use) == 0) continue;
    if (!text.empty()) text += ", ";
    text += name;
  }
  return text;
}

/// A backslash or a bar of a name does not end a cell of the table.
std::string cell(std::string_view content) {
  std::string text;
  for (const char c : content) {
    if (c == '\\' || c == '|') text += '\\';
    text += c;
  }
  return text;
}

std::string line_of(const IdnRow& row) {
  const auto idn = row.idn.text();
  const bool has_number = row.has_default || row.initial != 0.0;
  std::string text = "| " + std::string(idn.data(), idn.size());
  for (const auto& content : {cell(row.name), type_text(row), phases_text(row.attribute),
                              has_number ? number_text(row.initial) : "", range_text(row), cell(row.unit),
                              uses_text(row), row.line != 0 ? std::to_string(row.line) : "", cell(row.source)}) {
    text += " | " + content;
  }
  return text + " |\n";
}

}  // namespace

std::string idn_reference() {
  std::string page =
      "# IDNs of the ServoOne with SERCOS\n\n"
      "Made from the table of the drive's operation data by `driveline esi generate`. No simulated drive serves it "
      "yet.\n"
      "*Written in* are the phases that allow a write; on EtherCAT 2, 3 and 4 are PREOP, SAFEOP and OP. *Line* is the\n"
      "line of the manual with number, name, unit and phases; *source* tells where type, length, default and range "
      "are\n"
      "from: `manual` with a line, `as the MSD` for the parameter of the sibling drive, `AX2000`, `AX5000` and `S300` "
      "for\n"
      "IDN lists of these drives; \"ours\" marks what no source states.\n\n"
      "| IDN | name | type | written in | default | range | unit | use | line | source |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& row : servoone_idns().rows()) page += line_of(row);
  return page;
}

}  // namespace driveline::slaves::msd::sercos
