#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace driveline::snapshot {

/// Topics of a line over DDS whose rate can be set.
enum class FeedTopic : std::uint8_t {
  kAxisTelemetry,
  kLineStatus,
  kAxisBatch,
  kEvent,
  kSlave,
  kTopology,
  kCycleStatistics,
  kAxisState,
  kDiagnostics,
  kJointStates
};

/// Names of the topics, in the order of FeedTopic.
inline constexpr std::array<std::string_view, 10> kFeedTopicNames{
    "axis_telemetry", "line_status",      "axis_batch", "event",       "slave",
    "topology",       "cycle_statistics", "axis_state", "diagnostics", "joint_states"};

/// Number of topics.
inline constexpr std::size_t kFeedTopics = kFeedTopicNames.size();

/// When a topic is published.
enum class FeedRateKind : std::uint32_t {
  kDefault,   ///< the default of the topic
  kOff,       ///< never
  kOnChange,  ///< on change
  kCycles,    ///< every n-th cycle
  kPeriod     ///< at fixed intervals
};

}  // namespace driveline::snapshot
