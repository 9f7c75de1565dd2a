#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace driveline::trajectory {

/// Longest name of an axis, in characters: the limit of the telemetry records.
inline constexpr std::size_t kMaxAxisNameLength = 31;

/// Why a name cannot be that of an axis.
struct AxisNameError {
  /// The part of the rule that the name breaks.
  enum class Fault : std::uint8_t {
    kSpelling,  ///< too long, empty, `time`, or of other characters
    kTaken,     ///< another axis has it
  };
  Fault fault = Fault::kSpelling;  ///< the part of the rule that the name breaks
  std::string name;                ///< as it was given
};

/// The error as a sentence.
[[nodiscard]] std::string describe(const AxisNameError& error);

/// Whether `name` can be that of a further axis beside those that have the names `taken`.
///
/// The one rule for axes, in a line description as in the heading of a path: 1 to 31 characters out of letters (a to z,
/// A to Z), digits and "_-."; not `time`, which is the column beside them; no two alike.
[[nodiscard]] tl::expected<void, AxisNameError> check_axis_name(std::string_view name,
                                                                std::span<const std::string_view> taken = {});

/// The place of `name` among `names`; none: it is not there. Names are the same character by character: upper and lower
/// case differ.
[[nodiscard]] std::optional<std::size_t> find_axis_name(std::string_view name,
                                                        std::span<const std::string_view> names) noexcept;

/// Hint for a name that is not among `names`: `; there is "X", and upper and lower case differ` when a name differs in
/// case only, else empty.
[[nodiscard]] std::string axis_name_hint(std::string_view name, std::span<const std::string_view> names);

}  // namespace driveline::trajectory
