#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace driveline::esi {

/// Most notes of a file; the next one says that more are left out.
inline constexpr std::size_t kMaxNotes = 200;
/// Longest excerpt of a file in a message.
inline constexpr std::size_t kMaxQuoted = 60;

/// Converts ASCII letters to lower case.
[[nodiscard]] std::string lower_case(std::string_view text);

/// Removes white space at both ends of the text.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// Returns the text, cut behind kMaxQuoted characters.
[[nodiscard]] std::string shortened(std::string_view text);

}  // namespace driveline::esi
