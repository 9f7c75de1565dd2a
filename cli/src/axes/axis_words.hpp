#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/motion/single_axis/axis_request.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// Splits a line at spaces; double quotes keep a word with spaces together.
[[nodiscard]] std::vector<std::string> split_words(std::string_view line);
/// The word, in double quotes where it needs them.
[[nodiscard]] std::string quoted_word(std::string_view word);

/// The verbs of requests to an axis: "enable", "move" and so on.
[[nodiscard]] std::span<const std::string_view> axis_verbs();

/// Parses the words after the name of an axis: "move 90deg velocity=30deg/s". Numbers without a unit are in the unit of
/// the axis. Failure: status 2.
[[nodiscard]] Outcome<motion::AxisRequest> parse_axis_request(const motion::AxisConfig& axis,
                                                              std::span<const std::string> words);

/// The indices of the axes that `name` selects: one axis, or "all". Failure: status 2.
[[nodiscard]] Outcome<std::vector<std::size_t>> find_axes(std::span<const motion::AxisConfig> axes,
                                                          std::string_view name);

}  // namespace driveline::cli
