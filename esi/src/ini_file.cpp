#include "ini_file.hpp"

#include <algorithm>

#include "text.hpp"

namespace driveline::esi {
const IniValue* IniSection::find(std::string_view key) const {
  const auto found = values.find(std::string(key));
  return found == values.end() ? nullptr : &found->second;
}

tl::expected<IniFile, IniError> read_ini(std::string_view text) {
  IniFile file;
  IniSection* section = nullptr;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == ';' || line.front() == '#') continue;
    if (line.front() == '[' && line.back() == ']') {
      section = &file[lower_case(trimmed(line.substr(1, line.size() - 2)))];
      if (section->line == 0) section->line = number;
      continue;
    }
    const auto equals = line.find('=');
    if (section == nullptr || equals == std::string_view::npos || equals == 0) {
      return tl::unexpected(IniError{number, shortened(line)});
    }
    section->values.try_emplace(lower_case(trimmed(line.substr(0, equals))),
                                IniValue{std::string(trimmed(line.substr(equals + 1))), number});
  }
  return file;
}

}  // namespace driveline::esi
