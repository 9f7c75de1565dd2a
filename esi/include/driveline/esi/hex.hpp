#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::esi {

/// Bytes of a hexBinary text (two digits per byte, either case, white space between digits ignored).
[[nodiscard]] std::optional<std::vector<std::byte>> parse_hex(std::string_view text);

/// Upper-case hexBinary text.
[[nodiscard]] std::string to_hex(std::span<const std::byte> bytes);

}  // namespace driveline::esi
