#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/ecat_master/single_axis/axis_request.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The words of a line, separated by spaces; double quotes hold one together.
[[nodiscard]] std::vector<std::string> split_words(std::string_view line);
/// One word, in quotes where it needs them.
[[nodiscard]] std::string quoted_word(std::string_view word);

/// What can be asked of an axis, as it is written: "enable", "move" and so on.
[[nodiscard]] std::span<const std::string_view> axis_verbs();

/// What the words behind the name of an axis ask for: "move 90deg velocity=30deg/s". Numbers without a unit are in the
/// unit of the axis. Failure: status 2.
[[nodiscard]] Outcome<ecat_master::AxisRequest> parse_axis_request(const ecat_master::AxisConfig& axis,
                                                                   std::span<const std::string> words);

/// The numbers of the axes that `name` means: one, or "all". Failure: status 2.
[[nodiscard]] Outcome<std::vector<std::size_t>> find_axes(std::span<const ecat_master::AxisConfig> axes,
                                                          std::string_view name);

}  // namespace driveline::cli
