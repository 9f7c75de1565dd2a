#include "writer_qos.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>

#include "diagnostics.hpp"
#include "joint_states.hpp"

namespace driveline::bridge {
namespace {

namespace dds = eprosima::fastdds::dds;

/// Shortest deadline of the status, which is published ten times per second by default.
constexpr std::chrono::seconds kLeastDeadline{1};
constexpr std::int32_t kAxisHistory = 16;   // samples stored per axis
constexpr std::int32_t kBatchHistory = 4;   // batches
constexpr std::int32_t kRos2History = 10;   // messages
constexpr std::int32_t kEventHistory = 64;  // as specified in the IDL

/// Only the newest values matter: best effort, a short history per axis, allocated once.
dds::DataWriterQos axis_writer_qos(std::size_t axes) {
  const auto instances = static_cast<std::int32_t>(std::max<std::size_t>(axes, 1));
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kAxisHistory;
  qos.resource_limits().max_instances = instances;
  qos.resource_limits().max_samples_per_instance = kAxisHistory;
  qos.resource_limits().max_samples = instances * kAxisHistory;
  qos.resource_limits().allocated_samples = instances;
  qos.data_sharing().off();
  return qos;
}

/// Reliable with stored samples: a late subscriber must also receive the newest sample of each instance.
dds::DataWriterQos kept_writer_qos(std::size_t count) {
  // One more than the number of instances: a full history (depth times instances) loses its oldest sample, of any
  // instance, before Fast DDS 2.9 recognises that the new one replaces another.
  const auto instances = static_cast<std::int32_t>(std::max<std::size_t>(count, 1)) + 1;
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = 1;
  qos.resource_limits().max_instances = instances;
  qos.resource_limits().max_samples_per_instance = 1;
  qos.resource_limits().max_samples = instances;
  qos.resource_limits().allocated_samples = 1;
  qos.data_sharing().off();
  return qos;
}

/// A subscriber that requests a deadline or liveliness detects that a line is no longer reported.
dds::DataWriterQos status_writer_qos(const DdsConfig& config) {
  auto qos = kept_writer_qos(1);
  const auto promised = std::max<std::chrono::nanoseconds>(kLeastDeadline, 3 * config.status_period);
  const double seconds = std::chrono::duration<double>(promised).count();
  qos.deadline().period = eprosima::fastrtps::Duration_t(seconds);
  qos.liveliness().kind = dds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
  qos.liveliness().lease_duration = eprosima::fastrtps::Duration_t(seconds);
  qos.liveliness().announcement_period = eprosima::fastrtps::Duration_t(0.5 * seconds);
  return qos;
}

/// Like kept_writer_qos(), for a message that may be long.
dds::DataWriterQos kept_sequence_qos() {
  auto qos = kept_writer_qos(1);
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

/// A batch is large, and the next one follows within a millisecond.
dds::DataWriterQos batch_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kBatchHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kBatchHistory;
  qos.resource_limits().max_samples = kBatchHistory;
  qos.resource_limits().allocated_samples = 1;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

/// Late subscribers must also receive past events.
dds::DataWriterQos event_writer_qos() {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kEventHistory;
  qos.resource_limits().max_instances = 1;
  qos.resource_limits().max_samples_per_instance = kEventHistory;
  qos.resource_limits().max_samples = kEventHistory;
  qos.resource_limits().allocated_samples = kEventHistory;
  qos.data_sharing().off();
  return qos;
}

/// Like the defaults of ROS 2 writers: ROS 2 readers are reliable, and match only reliable writers.
dds::DataWriterQos ros2_writer_qos(const std::string& hash) {
  dds::DataWriterQos qos;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kRos2History;
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  qos.user_data().setValue({hash.begin(), hash.end()});
  return qos;
}

}  // namespace

dds::DataWriterQos writer_qos(TopicId topic, const DdsConfig& config) {
  switch (topic) {
    case TopicId::kAxis:
      return axis_writer_qos(config.axes.size());
    case TopicId::kBatch:
      return batch_writer_qos();
    case TopicId::kEvent:
      return event_writer_qos();
    case TopicId::kSlave:
      return kept_writer_qos(config.slaves);
    case TopicId::kAxisStatus:
      return kept_writer_qos(config.axes.size());
    case TopicId::kTopology:
      return kept_sequence_qos();
    case TopicId::kDiagnostics:
      return ros2_writer_qos(kDiagnosticsTypeHash);
    case TopicId::kJoints:
      return ros2_writer_qos(kJointStateTypeHash);
    case TopicId::kStatus:
      return status_writer_qos(config);
    case TopicId::kStatistics:
      return kept_writer_qos(1);
  }
  return {};
}

}  // namespace driveline::bridge
