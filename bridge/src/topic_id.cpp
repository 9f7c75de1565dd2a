#include "topic_id.hpp"

#include "diagnostics.hpp"
#include "joint_states.hpp"

namespace driveline::bridge {

std::string name_of(TopicId topic, const DdsConfig& config) {
  switch (topic) {
    case TopicId::kAxis:
      return config.axis_topic;
    case TopicId::kStatus:
      return config.status_topic;
    case TopicId::kBatch:
      return config.batch_topic;
    case TopicId::kEvent:
      return config.event_topic;
    case TopicId::kSlave:
      return config.slave_topic;
    case TopicId::kTopology:
      return config.topology_topic;
    case TopicId::kStatistics:
      return config.statistics_topic;
    case TopicId::kAxisStatus:
      return config.axis_state_topic;
    case TopicId::kDiagnostics:
      return config.ros2 && config.diagnostics ? kDiagnosticsTopic : "";
    case TopicId::kJoints:
      return config.ros2 && config.joint_states ? kJointStatesTopic : "";
  }
  return {};
}

std::vector<std::string> all_topic_names(const DdsConfig& config) {
  auto by_default = DdsConfig{};
  by_default.ros2 = true;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kTopics; ++i) {
    const auto topic = static_cast<TopicId>(i);
    const auto name = name_of(topic, config);
    names.push_back(name.empty() ? name_of(topic, by_default) : name);
  }
  return names;
}

}  // namespace driveline::bridge
