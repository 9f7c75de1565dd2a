#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::trajectory {

/// Longest name of an axis in characters; the telemetry records have no room for more.
inline constexpr std::size_t kMaxAxisNameLength = 31;

/// Reason why a name is not a valid axis name.
struct AxisNameError {
  /// The violated part of the rule.
  enum class Fault : std::uint8_t {
    kSpelling,  ///< too long, empty, `time`, or containing other characters
    kTaken,     ///< used by another axis
  };
  Fault fault = Fault::kSpelling;  ///< the violated part of the rule
  std::string name;                ///< the name as given
};

/// The error as a sentence.
[[nodiscard]] std::string describe(const AxisNameError& error);

/// Checks whether `name` is valid for a further axis beside those named in `taken`.
///
/// The single rule for axis names, in line descriptions as well as in the heading of a path: 1 to 31 characters out of
/// letters (a to z, A to Z), digits and "_-."; not `time`, which is the time column; all names differ.
[[nodiscard]] tl::expected<void, AxisNameError> check_axis_name(std::string_view name,
                                                                std::span<const std::string_view> taken = {});

/// Index of `name` in `names`; nullopt if it is absent. The comparison is case-sensitive.
[[nodiscard]] std::optional<std::size_t> find_axis_name(std::string_view name,
                                                        std::span<const std::string_view> names) noexcept;

/// Hint for a name that is not in `names`: `; there is "X", and upper and lower case differ` if a name differs in case
/// only, otherwise empty.
[[nodiscard]] std::string axis_name_hint(std::string_view name, std::span<const std::string_view> names);

}  // namespace driveline::trajectory
