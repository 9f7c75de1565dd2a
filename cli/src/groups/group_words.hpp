#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/ecat_master/axis/axis.hpp"
#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/event/group_events.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// A group whose requests are read.
struct NamedGroup {
  const runtime::AxisGroupConfig& config;
  std::span<const ecat_master::AxisConfig> axes;  ///< of the line
  /// Name, kind and unit of a coordinate of its moves: those of an axis, or of the tool.
  [[nodiscard]] ecat_master::AxisConfig coordinate(std::size_t number) const;
};

/// What can be asked of a group, as it is written; without `path`, which needs a file.
[[nodiscard]] std::span<const std::string_view> group_verbs();

/// What the words behind the name of a group ask for: "move 90mm 20mm feed=100mm/s". Numbers without a unit are in the
/// unit of their axis, feed and tolerance in that of the first one. Failure: status 2.
[[nodiscard]] Outcome<runtime::GroupRequest> parse_group_request(const NamedGroup& group,
                                                                 std::span<const std::string> words);

/// The number of the group with that name. Failure: status 2.
[[nodiscard]] Outcome<std::size_t> find_group(std::span<const runtime::AxisGroupConfig> groups, std::string_view name);

}  // namespace driveline::cli
