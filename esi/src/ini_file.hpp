#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::esi {

/// A value of an INI file, and its line.
struct IniValue {
  std::string text;      ///< without outer white space
  std::size_t line = 0;  ///< 1-based
};

/// A section of an INI file.
struct IniSection {
  std::size_t line = 0;                    ///< of its first heading, 1-based
  std::map<std::string, IniValue> values;  ///< by key in lower case; of equal keys the first one

  /// Returns the value of a key in lower case; null: the section does not have it.
  [[nodiscard]] const IniValue* find(std::string_view key) const;
};

/// The sections of an INI file by name in lower case. Sections of the same name are one.
using IniFile = std::map<std::string, IniSection, std::less<>>;

/// Why a text is not an INI file.
struct IniError {
  std::size_t line = 0;  ///< 1-based
  std::string problem;   ///< content of the line, shortened
};

/// Reads an INI file: `[section]`, `key=value`, and comments that start with `;` or `#` at the start of a line.
[[nodiscard]] tl::expected<IniFile, IniError> read_ini(std::string_view text);

}  // namespace driveline::esi
