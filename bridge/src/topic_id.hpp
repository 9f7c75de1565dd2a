#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "driveline/bridge/dds_config.hpp"

namespace driveline::bridge {

/// The topics of a line.
enum class TopicId : std::uint8_t {
  kAxis,
  kStatus,
  kBatch,
  kEvent,
  kSlave,
  kTopology,
  kStatistics,
  kAxisStatus,
  kDiagnostics,
  kJoints
};

/// Number of topics.
inline constexpr std::size_t kTopics = static_cast<std::size_t>(TopicId::kJoints) + 1;

/// Name of the DDS topic; empty: not published.
[[nodiscard]] std::string name_of(TopicId topic, const DdsConfig& config);
/// Names of all DDS topics of a line; topics that are not published have their default names.
[[nodiscard]] std::vector<std::string> all_topic_names(const DdsConfig& config);

}  // namespace driveline::bridge
