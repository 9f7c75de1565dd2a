#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace driveline::esi {

/// Converts hexBinary text (two digits per byte, either case, white space ignored) to bytes; nullopt for any other
/// text.
[[nodiscard]] std::optional<std::vector<std::byte>> parse_hex(std::string_view text);

/// Converts bytes to upper-case hexBinary text.
[[nodiscard]] std::string to_hex(std::span<const std::byte> bytes);

}  // namespace driveline::esi
