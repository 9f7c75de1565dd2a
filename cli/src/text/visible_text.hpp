#pragma once

#include <string>
#include <string_view>

namespace driveline::cli {

/// Makes `text` safe for output on a terminal. It may come from files and slaves: control characters except line ends
/// and tabs, and bytes that are not UTF-8, are escaped as in C, `\x1B`.
[[nodiscard]] std::string visible_text(std::string_view text);

/// The same for a JSON document, where such a character is part of a string: `\u001B`.
[[nodiscard]] std::string visible_json(std::string_view document);

}  // namespace driveline::cli
