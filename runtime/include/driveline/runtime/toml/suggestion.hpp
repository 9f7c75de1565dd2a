#pragma once

#include <span>
#include <string>
#include <string_view>

namespace driveline::runtime {

/// The word of `known` that `word` is a misspelling of, by few inserted, missing, wrong or swapped letters; or the only
/// one that begins with it. Empty: none is near enough.
[[nodiscard]] std::string closest(std::string_view word, std::span<const std::string_view> known);

}  // namespace driveline::runtime
