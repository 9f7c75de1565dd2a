#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace driveline::cli {

/// Columns of the narrowest terminal that text is made for.
inline constexpr std::size_t kTextColumns = 80;

/// `prefix` and `text`, in lines of at most kTextColumns where the words permit it; further lines are indented by the
/// length of `prefix`. No line feed at the end.
[[nodiscard]] std::string wrapped(std::string_view prefix, std::string_view text);

/// `text`, for a column of a table: if it has more than `columns` characters, its begin and "...". `columns`: at
/// least 4.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t columns);

}  // namespace driveline::cli
