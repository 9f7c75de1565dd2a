#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace driveline::trajectory {

/// Longest name of an axis, in characters: what the telemetry holds beside the end of the text.
inline constexpr std::size_t kMaxAxisNameLength = 31;

/// Why `name` cannot be that of a further axis beside those that have the names `taken`, as a sentence; empty: it can.
///
/// The one rule for axes, in a line description as in the heading of a path: 1 to 31 characters out of letters (a to z,
/// A to Z), digits and "_-."; not `time`, which is the column beside them; no two alike.
[[nodiscard]] std::string axis_name_fault(std::string_view name, std::span<const std::string_view> taken = {});

/// The place of `name` among `names`; none: it is not there. Names are the same character by character: upper and lower
/// case differ.
[[nodiscard]] std::optional<std::size_t> find_axis_name(std::string_view name,
                                                        std::span<const std::string_view> names) noexcept;

/// Of a name that is not among `names`: `; there is "X", and upper and lower case differ` when that is all that is
/// wrong with it, else empty.
[[nodiscard]] std::string axis_name_hint(std::string_view name, std::span<const std::string_view> names);

}  // namespace driveline::trajectory
