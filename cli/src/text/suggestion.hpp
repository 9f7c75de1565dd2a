#pragma once

#include <span>
#include <string>
#include <string_view>

namespace driveline::cli {

/// The one of `known` that somebody has meant who typed `word`: so few letters are left out, too many, others or
/// swapped that it is no other word; or the only one that begins with it. Empty: nothing is near enough.
[[nodiscard]] std::string closest(std::string_view word, std::span<const std::string> known);

}  // namespace driveline::cli
