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

/// Their names, in that order.
inline constexpr std::array<std::string_view, 10> kFeedTopicNames{
    "axis_telemetry", "line_status",      "axis_batch", "event",       "slave",
    "topology",       "cycle_statistics", "axis_state", "diagnostics", "joint_states"};

/// How many there are.
inline constexpr std::size_t kFeedTopics = kFeedTopicNames.size();

/// How a topic is published.
enum class FeedRateKind : std::uint32_t {
  kDefault,   ///< as the topic is by itself
  kOff,       ///< not at all
  kOnChange,  ///< when something has changed
  kCycles,    ///< every n-th cycle
  kPeriod     ///< in intervals
};

}  // namespace driveline::snapshot
