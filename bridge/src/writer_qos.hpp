#pragma once

#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>

#include "driveline/bridge/dds_config.hpp"
#include "topic_id.hpp"

namespace driveline::bridge {

/// QoS of the writer of a topic.
[[nodiscard]] eprosima::fastdds::dds::DataWriterQos writer_qos(TopicId topic, const DdsConfig& config);

}  // namespace driveline::bridge
