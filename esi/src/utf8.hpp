#pragma once

#include <string>
#include <string_view>

namespace driveline::esi {

/// Converts a text to UTF-8: from UTF-16 when it has a UTF-16 byte order mark; unchanged when it is valid UTF-8;
/// otherwise from ISO 8859-1, which some vendors use.
[[nodiscard]] std::string to_utf8(std::string_view text);

}  // namespace driveline::esi
