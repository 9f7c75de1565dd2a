#pragma once

#include <string>
#include <string_view>

namespace driveline::esi {

/// The text as UTF-8: converted when a byte order mark says UTF-16, itself when it is valid UTF-8 already, else taken
/// as ISO 8859-1, which vendors' files are in.
[[nodiscard]] std::string to_utf8(std::string_view text);

}  // namespace driveline::esi
