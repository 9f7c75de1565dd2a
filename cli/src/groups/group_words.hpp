#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/motion/axis/axis.hpp"
#include "driveline/runtime/config/axis_group_config.hpp"
#include "driveline/runtime/event/group_events.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// The group that a request is parsed for.
struct NamedGroup {
  const runtime::AxisGroupConfig& config;
  std::span<const motion::AxisConfig> axes;  ///< all axes of the line
  /// Name, kind and unit of a coordinate of its moves: an axis, or a coordinate of the tool.
  [[nodiscard]] motion::AxisConfig coordinate(std::size_t number) const;
};

/// The verbs of requests to a group, except `path`, which needs a file.
[[nodiscard]] std::span<const std::string_view> group_verbs();

/// Parses the words after the name of a group: "move 90mm 20mm feed=100mm/s". Numbers without a unit are in the unit of
/// their axis, feed and tolerance in that of the first axis. Failure: status 2.
[[nodiscard]] Outcome<runtime::ClientGroupRequest> parse_group_request(const NamedGroup& group,
                                                                       std::span<const std::string> words);

/// The index of the group with that name. Failure: status 2.
[[nodiscard]] Outcome<std::size_t> find_group(std::span<const runtime::AxisGroupConfig> groups, std::string_view name);

}  // namespace driveline::cli
