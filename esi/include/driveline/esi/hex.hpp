#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::esi {

/// Converts hexBinary text to bytes (two digits per byte, either case, white space between digits ignored). Returns
/// nullopt for any other text.
[[nodiscard]] std::optional<std::vector<std::byte>> parse_hex(std::string_view text);

/// Converts bytes to upper-case hexBinary text.
[[nodiscard]] std::string to_hex(std::span<const std::byte> bytes);

}  // namespace driveline::esi
