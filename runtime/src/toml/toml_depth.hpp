#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace driveline::runtime {

/// Limit for levels of dotted keys, `a.b.c`, and of nested values, `[[1]]`. A line description needs four; parser and
/// tables use stack for every level, and a file must not decide how much.
inline constexpr std::size_t kMaxTomlDepth = 32;

/// The line, from 1, on which TOML text is nested deeper than kMaxTomlDepth; nothing if it is not. Strings and comments
/// do not count. For text that is no TOML the result is arbitrary; the parser reports the error.
[[nodiscard]] std::optional<std::size_t> too_deep_line(std::string_view toml) noexcept;

}  // namespace driveline::runtime
