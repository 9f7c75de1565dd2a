#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace driveline::runtime {

/// Limit for levels of dotted keys, `a.b.c`, and of nested values, `[[1]]`. A line description needs four. Parser and
/// tables use stack for every level, so a file must not determine how much.
inline constexpr std::size_t kMaxTomlDepth = 32;

/// Returns the line, from 1, on which TOML text is nested deeper than kMaxTomlDepth; none if it is not. Ignores strings
/// and comments. For text that is not TOML the result is arbitrary; the parser reports the error.
[[nodiscard]] std::optional<std::size_t> too_deep_line(std::string_view toml) noexcept;

}  // namespace driveline::runtime
