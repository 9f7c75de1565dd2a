#pragma once

#include <span>
#include <string>
#include <string_view>

namespace driveline::runtime {

/// Returns the word of `known` of which `word` is probably a misspelling, by a few inserted, missing, wrong or swapped
/// letters; or the only one that starts with `word`. Empty: none is similar enough.
[[nodiscard]] std::string closest(std::string_view word, std::span<const std::string_view> known);

}  // namespace driveline::runtime
