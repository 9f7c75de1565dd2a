#pragma once

#include <memory>

namespace eprosima::fastdds::rtps {
struct TransportDescriptorInterface;
}  // namespace eprosima::fastdds::rtps

namespace driveline::bridge {

/// Fast DDS's shared memory in one direction: samples go by it to readers that run as the same user as this process. No
/// port of this process is announced, so everything that it receives arrives by another transport. The transports
/// listed before this one send the samples to these readers as well.
///
/// Fast DDS 2.9 alone would write only to the shared memory ports of all readers of this machine, and they to the ports
/// of this process, although its segments and ports have mode 0644: between two users everything would be lost.
[[nodiscard]] std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> shared_memory_to_own_user();

}  // namespace driveline::bridge
