#pragma once

#include <cstddef>
#include <cstdint>

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

/// How many there are.
inline constexpr std::size_t kTopics = static_cast<std::size_t>(TopicId::kJoints) + 1;

}  // namespace driveline::bridge
