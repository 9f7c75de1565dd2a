#pragma once

#include <string>
#include <string_view>

namespace driveline::cli {

/// `text` for people, without anything that a terminal would obey. Files and slaves put into it what they like: control
/// characters but line ends and tabs, and bytes that are no UTF-8, become `\x1B`, as C writes them.
[[nodiscard]] std::string visible_text(std::string_view text);

/// The same for a JSON document, in which such a character is part of a string: `\u001B`.
[[nodiscard]] std::string visible_json(std::string_view document);

}  // namespace driveline::cli
