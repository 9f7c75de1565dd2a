#include "text/register_name.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <cctype>
#include <vector>

#include "commands/tool_options.hpp"

namespace driveline::cli {
namespace {

/// The letters and digits of a name in lower case, for comparing names.
std::string folded(std::string_view text) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) result += static_cast<char>(std::tolower(byte));
  }
  return result;
}

std::string_view access_text(wire::RegisterAccess access) {
  switch (access) {
    case wire::RegisterAccess::kNone:
      return "--";
    case wire::RegisterAccess::kRead:
      return "r-";
    case wire::RegisterAccess::kWrite:
      return "-w";
    case wire::RegisterAccess::kReadWrite:
      return "rw";
    case wire::RegisterAccess::kReadClearOnWrite:
      return "rc";
  }
  return "?";
}

Outcome<const wire::RegisterRow*> find_row(std::string_view text) {
  const auto wanted = folded(text);
  std::vector<const wire::RegisterRow*> found;
  for (const auto& row : wire::kRegisters) {
    const auto name = folded(row.name);
    if (name == wanted) return &row;
    if (!wanted.empty() && name.find(wanted) != std::string::npos) found.push_back(&row);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    return misused(
        fmt::format("register \"{}\": an address such as 0x0130 or a name is expected; `driveline reg list` "
                    "lists the names",
                    text));
  }
  std::vector<std::string> names;
  for (const auto* row : found) names.push_back(fmt::format("0x{:04X} {}", row->address, row->name));
  return misused(fmt::format("register \"{}\" may be {}", text, fmt::join(names, ", ")));
}

RegisterAddress at_element(const wire::RegisterRow& row, std::uint32_t element) {
  return {static_cast<std::uint16_t>(row.address + element * row.stride), element_bytes(row), &row};
}

}  // namespace

std::uint16_t element_bytes(const wire::RegisterRow& row) noexcept {
  // Arrays of single bytes with a larger stride are channels of several bytes (FMMU, sync manager); other arrays are
  // counters.
  return row.size == 1 && row.stride >= 8 ? row.stride : row.size;
}

Outcome<RegisterAddress> find_register(std::string_view text) {
  if (const auto number = parse_number(text, 0xFFFF, "register")) {
    for (const auto& row : wire::kRegisters) {
      if (*number < row.address || *number >= row.end()) continue;
      const auto element = (*number - row.address) / row.stride;
      if (*number == row.address + element * row.stride) return at_element(row, element);
    }
    return RegisterAddress{static_cast<std::uint16_t>(*number), 0, nullptr};
  }
  std::uint32_t element = 0;
  auto name = text;
  const bool indexed = text.ends_with(']') && text.find('[') != std::string_view::npos;
  if (indexed) {
    name = text.substr(0, text.find('['));
    const auto digits = text.substr(name.size() + 1, text.size() - name.size() - 2);
    const auto number = parse_number(digits, 0xFFFF, "element");
    if (!number) return tl::unexpected(number.error());
    element = *number;
  }
  const auto row = find_row(name);
  if (!row) return tl::unexpected(row.error());
  if (element >= (*row)->count) {
    return misused(fmt::format("register \"{}\": {} has {} element{}, counted from 0", text, (*row)->name,
                               (*row)->count, (*row)->count == 1 ? "" : "s"));
  }
  return at_element(**row, element);
}

std::string register_table() {
  std::string text = "address  bytes  elements  access  name\n";
  for (const auto& row : wire::kRegisters) {
    text += fmt::format("0x{:04X}  {:>6}  {:>8}  {:<6}  {}\n", row.address, element_bytes(row), row.count,
                        access_text(row.ecat), row.name);
  }
  return text;
}

}  // namespace driveline::cli
