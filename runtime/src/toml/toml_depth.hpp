#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace driveline::runtime {

/// Levels of dotted keys, `a.b.c`, and of values in each other, `[[1]]`. A line description needs four; the parser and
/// the tables that it makes take stack for every level, so a file decides how much.
inline constexpr std::size_t kMaxTomlDepth = 32;

/// The line, from 1, on which TOML text goes deeper than kMaxTomlDepth; nothing: it does not. Strings and comments do
/// not count. Text that is no TOML gets some answer, for the parser to complain about.
[[nodiscard]] std::optional<std::size_t> too_deep_line(std::string_view toml) noexcept;

}  // namespace driveline::runtime
